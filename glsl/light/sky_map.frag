// Of a depth map the depth alone is kept.
void main() {}
