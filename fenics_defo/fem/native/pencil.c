/* Products of K - a M and M with blocks of vectors, in one pass over both.
 *
 * K is in 3x3 blocks, each stored column by column as PETSc does; M = m times the identity of 3x3,
 * with m on the same pattern of nodes. Vectors are columns; inside, eight of them lie side by side in
 * rows of `packed`, so that each block of K is read once for all and a node's values are neighbours.
 */
#include <stdint.h>

enum { WIDE = 8, HALF = 4, TILE = 8 /* nodes whose results are turned into columns together */ };

/* Four numbers that the compiler keeps in one register where the processor has such. */
typedef double four __attribute__((vector_size(HALF * sizeof(double)), aligned(sizeof(double))));

/* Columns (rows, width) to rows of eight, with zeros where there are fewer. */
void fenics_defo_pack(int64_t rows, int width, const double *columns, double *packed)
{
  for (int64_t begin = 0; begin < rows; begin += TILE) {
    const int64_t end = begin + TILE < rows ? begin + TILE : rows;
    for (int j = 0; j < WIDE; ++j)
      for (int64_t r = begin; r < end; ++r)
        packed[WIDE * r + j] = j < width ? columns[j * rows + r] : 0.0;
  }
}

static void unpack(int64_t rows, int64_t begin, int count, int width, const double *tile,
                   double *columns)
{
  for (int j = 0; j < width; ++j)
    for (int r = 0; r < count; ++r)
      columns[j * rows + begin + r] = tile[WIDE * r + j];
}

/* One node's rows of K x - a m x and m x, for four of the eight columns. */
static inline void row(int64_t begin, int64_t end, const int32_t *columns, const double *K,
                       const double *m, const double *packed, const double *shift, double *image,
                       double *momentum)
{
  four k0 = {0}, k1 = {0}, k2 = {0}, m0 = {0}, m1 = {0}, m2 = {0};
  const four a = *(const four *)shift;
  for (int64_t p = begin; p < end; ++p) {
    const double *x = packed + 3 * WIDE * (int64_t)columns[p], *block = K + 9 * p, mass = m[p];
    const four x0 = *(const four *)x, x1 = *(const four *)(x + WIDE),
               x2 = *(const four *)(x + 2 * WIDE);
    k0 += block[0] * x0 + block[3] * x1 + block[6] * x2;
    k1 += block[1] * x0 + block[4] * x1 + block[7] * x2;
    k2 += block[2] * x0 + block[5] * x1 + block[8] * x2;
    m0 += mass * x0;
    m1 += mass * x1;
    m2 += mass * x2;
  }
  *(four *)image = k0 - a * m0;
  *(four *)(image + WIDE) = k1 - a * m1;
  *(four *)(image + 2 * WIDE) = k2 - a * m2;
  *(four *)momentum = m0;
  *(four *)(momentum + WIDE) = m1;
  *(four *)(momentum + 2 * WIDE) = m2;
}

/* K X - M X a and M X by columns (3 nodes, width), width at most 8; `momenta` may be null. */
void fenics_defo_pencil(int64_t nodes, const int64_t *first, const int32_t *columns,
                        const double *K, const double *m, const double *packed,
                        const double *shifts, int width, double *images, double *momenta)
{
  double image[3 * TILE * WIDE], momentum[3 * TILE * WIDE];
  for (int64_t begin = 0; begin < nodes; begin += TILE) {
    const int count = begin + TILE < nodes ? TILE : (int)(nodes - begin);
    for (int i = 0; i < count; ++i)
      for (int half = 0; half < width; half += HALF) {
        const int place = 3 * WIDE * i + half;
        row(first[begin + i], first[begin + i + 1], columns, K, m, packed + half, shifts + half,
            image + place, momentum + place);
      }
    unpack(3 * nodes, 3 * begin, 3 * count, width, image, images);
    if (momenta)
      unpack(3 * nodes, 3 * begin, 3 * count, width, momentum, momenta);
  }
}
