/* The most multiplications and additions a core does: independent chains of fused ones. */
typedef float lanes __attribute__((vector_size(32)));

float fma_chains(long rounds) {
    lanes sums[12], factor, shift;
    for (int lane = 0; lane < 8; lane++) {
        factor[lane] = 0.999999f;
        shift[lane] = 1e-6f;
        for (int chain = 0; chain < 12; chain++) sums[chain][lane] = (float)(chain + lane);
    }
    for (long round = 0; round < rounds; round++)
#pragma GCC unroll 12
        for (int chain = 0; chain < 12; chain++) sums[chain] = sums[chain] * factor + shift;
    float total = 0;
    for (int chain = 0; chain < 12; chain++)
        for (int lane = 0; lane < 8; lane++) total += sums[chain][lane];
    return total;
}
