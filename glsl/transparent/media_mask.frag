// Writes a depth, where tiles see a medium, and no colour.
void main() {}
