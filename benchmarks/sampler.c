/* As many trajectories as a core draws when nothing is left to a compiler: eight agents in a vector,
 * forward agent, moves through walls drawn again, two scans of nine rays. A bound, not a peer: no
 * margins about walls, no keys, nobody ever begins anew. */
#include <stdint.h>
#define RAYS 9
#define STEPS 6
#define MAX_TRIES 30

typedef float lanes __attribute__((vector_size(32)));
typedef int32_t ints __attribute__((vector_size(32)));
typedef uint32_t words __attribute__((vector_size(32)));

static inline lanes choose(ints mask, lanes yes, lanes no) {
    return (lanes)(((ints)yes & mask) | ((ints)no & ~mask));
}

static inline int any(ints mask) {
    int found = 0;
    for (int lane = 0; lane < 8; lane++) found |= mask[lane];
    return found;
}

/* xoshiro128+, eight streams. */
static inline lanes uniform(words s[4]) {
    words sum = s[0] + s[3], t = s[1] << 9;
    s[2] ^= s[0], s[3] ^= s[1], s[1] ^= s[2], s[0] ^= s[3], s[2] ^= t;
    s[3] = (s[3] << 11) | (s[3] >> 21);
    return (lanes)((sum >> 9) | 0x3f800000u) - 1.0f;
}

/* Sine and cosine of an angle within one turn, by its quarter: both odd and even polynomials. */
static inline void sine_cosine(lanes angle, lanes *sine, lanes *cosine) {
    lanes half = angle * 0.5f, q = half * half;
    lanes s = half * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 + q * (-1.0f / 5040 + q / 362880))));
    lanes c = 1.0f + q * (-0.5f + q * (1.0f / 24 + q * (-1.0f / 720 + q * (1.0f / 40320 - q / 3628800))));
    *sine = 2.0f * s * c, *cosine = 1.0f - 2.0f * s * s;
}

static void scan(const float (*walls)[4], int num_walls, const float (*fan)[2], lanes x, lanes y,
                 lanes c, lanes s, lanes *ranges) {
    lanes nearness[RAYS], rc[RAYS], rs[RAYS];
    for (int ray = 0; ray < RAYS; ray++) {
        nearness[ray] = (lanes){} + 0.1f;
        rc[ray] = fan[ray][0] * c - fan[ray][1] * s, rs[ray] = fan[ray][1] * c + fan[ray][0] * s;
    }
    for (int w = 0; w < num_walls; w++) {
        lanes ax = walls[w][0] - x, ay = walls[w][1] - y, bx = walls[w][2] - x, by = walls[w][3] - y;
        lanes inverse = 1.0f / (ax * by - ay * bx);
#pragma GCC unroll 9
        for (int ray = 0; ray < RAYS; ray++) {
            lanes a = rc[ray] * ay - rs[ray] * ax, b = rc[ray] * by - rs[ray] * bx;
            lanes near = (b - a) * inverse;
            ints met = ((ints)a ^ (ints)b) < 0;
            nearness[ray] = choose(met & (near > nearness[ray]), near, nearness[ray]);
        }
    }
    for (int ray = 0; ray < RAYS; ray++) ranges[ray] = 1.0f / nearness[ray];
}

static ints meets(const float (*walls)[4], int num_walls, lanes x, lanes y, lanes dx, lanes dy) {
    ints met = {};
    for (int w = 0; w < num_walls; w++) {
        float ex = walls[w][2] - walls[w][0], ey = walls[w][3] - walls[w][1];
        lanes ax = walls[w][0] - x, ay = walls[w][1] - y;
        lanes here = ex * ay - ey * ax, there = here - (ex * dy - ey * dx);
        lanes a = dx * ay - dy * ax, b = a + (dx * ey - dy * ex);
        met |= (((ints)here ^ (ints)there) & ((ints)a ^ (ints)b)) < 0;
    }
    return met;
}

/* Draws num trajectories (a multiple of eight) into out, 32 vectors for every eight of them: commands,
 * sensors before and after, and where the last pose lies. */
float draw(long num, const float (*walls)[4], int num_walls, const float (*fan)[2], float max_turn,
           uint32_t seed, lanes *out) {
    words state[4];
    for (int i = 0; i < 4; i++)
        for (int lane = 0; lane < 8; lane++)
            state[i][lane] = seed = seed * 1664525u + 1013904223u;
    lanes refused = {};
    for (long n = 0; n < num; n += 8, out += 2 * STEPS + 2 * RAYS + 2) {
        lanes x = 40.0f * uniform(state), y = 40.0f * uniform(state), c, s;
        sine_cosine(6.2831853f * uniform(state) - 3.1415927f, &s, &c);
        scan(walls, num_walls, fan, x, y, c, s, out + 2 * STEPS);
        for (int step = 0; step < STEPS; step++) {
            ints waiting = (ints){} - 1;
            for (int tries = 0; tries < MAX_TRIES && any(waiting); tries++) {
                lanes turn = max_turn * (2.0f * uniform(state) - 1.0f), move = uniform(state), ts, tc;
                sine_cosine(turn, &ts, &tc);
                lanes nc = c * tc - s * ts, ns = s * tc + c * ts, dx = move * nc, dy = move * ns;
                ints taken = waiting & ~meets(walls, num_walls, x, y, dx, dy);
                x = choose(taken, x + dx, x), y = choose(taken, y + dy, y);
                c = choose(taken, nc, c), s = choose(taken, ns, s);
                out[2 * step] = choose(taken, turn, out[2 * step]);
                out[2 * step + 1] = choose(taken, move, out[2 * step + 1]);
                waiting &= ~taken;
                refused += choose(waiting, (lanes){} + 1.0f, (lanes){});
            }
        }
        scan(walls, num_walls, fan, x, y, c, s, out + 2 * STEPS + RAYS);
        out[2 * STEPS + 2 * RAYS] = x, out[2 * STEPS + 2 * RAYS + 1] = y;
    }
    float total = 0;
    for (int lane = 0; lane < 8; lane++) total += refused[lane];
    return total / num;
}
