/* One chain by the scheme of the paper's Appendix, in the laboratory frame: the loop that one would
   write first. `bench.py` compiles and calls it. */

#include <math.h>
#include <stdint.h>

#define STATIC_FRICTION 71.4
#define FRICTION_RATIO 0.45
#define REST_LENGTH 50.0
#define LINEAR_LIMIT 20.0
#define COMPRESSION_RATE 0.2
#define EXTENSION_RATE 0.01

enum { HAS_SPARE, SPARE, SUM, SUM_OF_SQUARES }; /* of `carry` */

static double spring_force(double deformation)
{
    if (deformation < -LINEAR_LIMIT)
        return LINEAR_LIMIT
            + (exp(COMPRESSION_RATE * (-deformation - LINEAR_LIMIT)) - 1.0) / COMPRESSION_RATE;
    if (deformation <= LINEAR_LIMIT)
        return -deformation;
    return -(LINEAR_LIMIT
             + (exp(EXTENSION_RATE * (deformation - LINEAR_LIMIT)) - 1.0) / EXTENSION_RATE);
}

static uint64_t rotate(uint64_t word, int count)
{
    return (word << count) | (word >> (64 - count));
}

/* xoshiro256++ (Blackman and Vigna, ACM TOMS 47, 36, 2021) */
static uint64_t next_word(uint64_t *stream)
{
    uint64_t word = rotate(stream[0] + stream[3], 23) + stream[0];
    uint64_t shifted = stream[1] << 17;
    stream[2] ^= stream[0];
    stream[3] ^= stream[1];
    stream[1] ^= stream[2];
    stream[0] ^= stream[3];
    stream[2] ^= shifted;
    stream[3] = rotate(stream[3], 45);
    return word;
}

static double uniform(uint64_t *stream)
{
    return ((double)(next_word(stream) >> 11) + 0.5) * 0x1p-53;
}

/* Marsaglia's polar method: two deviates at a time, one is kept for the next call */
static double normal(uint64_t *stream, double *carry)
{
    double a, b, square, factor;
    if (carry[HAS_SPARE] != 0.0) {
        carry[HAS_SPARE] = 0.0;
        return carry[SPARE];
    }
    do {
        a = 2.0 * uniform(stream) - 1.0;
        b = 2.0 * uniform(stream) - 1.0;
        square = a * a + b * b;
    } while (square >= 1.0 || square == 0.0);
    factor = sqrt(-2.0 * log(square) / square);
    carry[HAS_SPARE] = 1.0;
    carry[SPARE] = b * factor;
    return a * factor;
}

/* state: rows x, x one step before, v, a one step before, F_st, direction of slip; (6, n_blocks).
   stream: 4 words. carry: a spare deviate, and sums of x_N and its square over the steps done. */
void advance_chain(int64_t n_blocks, double belt_velocity, double noise, double time_step,
                   int64_t n_steps, double *restrict state, uint64_t *restrict stream,
                   double *restrict carry)
{
    double *x = state, *before = state + n_blocks, *v = state + 2 * n_blocks;
    double *a_before = state + 3 * n_blocks, *threshold = state + 4 * n_blocks;
    double *direction = state + 5 * n_blocks;
    double springs[n_blocks + 1];

    for (int64_t step = 0; step < n_steps; step++) {
        for (int64_t i = 0; i < n_blocks; i++)
            springs[i] = spring_force(x[i] - (i ? x[i - 1] : 0.0) - REST_LENGTH);
        springs[n_blocks] = 0.0;
        for (int64_t i = 0; i < n_blocks; i++) {
            double force = springs[i] - springs[i + 1];
            double free, after;
            if (noise > 0.0 && direction[i] != 0.0)
                threshold[i] = STATIC_FRICTION + noise * normal(stream, carry);
            free = fabs(force) > threshold[i] ? copysign(1.0, force) : 0.0;
            if (direction[i] * (v[i] - belt_velocity) <= 0.0 && free != direction[i]) {
                if (direction[i] == 0.0 || free == 0.0) {
                    before[i] = x[i] - belt_velocity * time_step;
                    a_before[i] = 0.0;
                }
                direction[i] = free;
            }
            if (direction[i] == 0.0) {
                after = x[i] + belt_velocity * time_step;
                v[i] = belt_velocity;
            } else {
                double a = force - direction[i] * FRICTION_RATIO * threshold[i];
                after = 2.0 * x[i] - before[i] + a * time_step * time_step;
                v[i] = (x[i] - before[i]) / time_step
                    + time_step / 6.0 * (11.0 * a - 2.0 * a_before[i]);
                a_before[i] = a;
            }
            before[i] = x[i];
            x[i] = after;
        }
        carry[SUM] += x[n_blocks - 1];
        carry[SUM_OF_SQUARES] += x[n_blocks - 1] * x[n_blocks - 1];
    }
}
