// Something for each pair of opposite ways.
//
// llvmpipe gathers a uniform whose index is a loop's, for each lane and number; of a literal index it loads it once.
#define FOR_PAIRS_OF_26(f, first)                                                                          \
    f(first) f(first + 2) f(first + 4) f(first + 6) f(first + 8) f(first + 10) f(first + 12) f(first + 14) \
        f(first + 16) f(first + 18) f(first + 20) f(first + 22) f(first + 24)
#define FOR_PAIRS_OF_48(f, first)                                                                                   \
    FOR_PAIRS_OF_26(f, first)                                                                                       \
    f(first + 26) f(first + 28) f(first + 30) f(first + 32) f(first + 34) f(first + 36) f(first + 38) f(first + 40) \
        f(first + 42) f(first + 44) f(first + 46)
