/* Loops over cells that add element forces and element stiffnesses to a body's.
 *
 * Blocks of the stiffness are 3x3, row by row; `positions` holds for each pair of a cell's nodes the
 * number of its block. Reference gradients are (points, nodes, 3), the inverse Jacobians J^-1 of the
 * cells' maps (cells, points, 3, 3) and the weights (cells, points), the Jacobian's determinant
 * included. The indices of a response's tangent are A_ijkl = dP_ij / dF_kl.
 */
#include <stdint.h>
#include <string.h>

enum { MOST = 27 }; /* nodes of a cell */

typedef void (*tabulate_t)(double *, const double *, const double *, const double *, const int *,
                           const uint8_t *, void *);

/* Number of each pair's block in rows of sorted columns; returns the count of pairs that have none. */
int64_t fenics_defo_positions(int64_t cells, int n, const int32_t *nodes, const int64_t *first,
                              const int32_t *columns, int32_t *positions)
{
  int64_t missing = 0;
  for (int64_t e = 0; e < cells; ++e)
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        const int32_t row = nodes[e * n + a], column = nodes[e * n + b];
        int64_t low = first[row], high = first[row + 1];
        while (low < high) {
          const int64_t middle = (low + high) / 2;
          if (columns[middle] < column)
            low = middle + 1;
          else
            high = middle;
        }
        if (low == first[row + 1] || columns[low] != column)
          ++missing;
        positions[(e * n + a) * n + b] = (int32_t)low;
      }
  return missing;
}

/* Blocks of a form's kernel, as FFCx compiles it, on cells or on their facets. */
void fenics_defo_add_kernel(tabulate_t tabulate, int64_t count, const int32_t *cells,
                            const int32_t *facets, const double *coefficients, int64_t width,
                            const double *constants, const double *x, const int32_t *corners,
                            int corner_count, const int32_t *positions, int n, double *values)
{
  double K[9 * MOST * MOST], place[3 * MOST];
  const uint8_t permutation = 0;
  for (int64_t e = 0; e < count; ++e) {
    const int64_t cell = cells[e];
    const int32_t *own = corners + cell * corner_count, *position = positions + cell * n * n;
    for (int a = 0; a < corner_count; ++a)
      memcpy(place + 3 * a, x + 3 * (int64_t)own[a], 3 * sizeof(double));
    memset(K, 0, 9 * n * n * sizeof(double));
    tabulate(K, coefficients + e * width, constants, place, facets ? facets + e : 0, &permutation, 0);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        double *block = values + 9 * (int64_t)position[a * n + b];
        const double *entry = K + 9 * a * n + 3 * b;
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k)
            block[3 * i + k] += entry[3 * i * n + k];
      }
  }
}

/* F = I + grad u at the points of cells. */
void fenics_defo_gradients(int64_t count, int points, int n, const double *reference,
                           const double *inverse, const int32_t *nodes, const double *u, double *F)
{
  for (int64_t e = 0; e < count; ++e) {
    double own[3 * MOST];
    for (int a = 0; a < n; ++a)
      memcpy(own + 3 * a, u + 3 * (int64_t)nodes[e * n + a], 3 * sizeof(double));
    for (int q = 0; q < points; ++q) {
      const double *d = reference + 3 * q * n, *inv = inverse + 9 * (e * points + q);
      double slope[9] = {0};
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < 3; ++i)
          for (int l = 0; l < 3; ++l)
            slope[3 * i + l] += own[3 * a + i] * d[3 * a + l];
      double *out = F + 9 * (e * points + q);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          out[3 * i + j] = (i == j) + slope[3 * i] * inv[j] + slope[3 * i + 1] * inv[3 + j]
                           + slope[3 * i + 2] * inv[6 + j];
    }
  }
}

/* Forces of the stress P at the points of cells. */
void fenics_defo_add_forces(int64_t count, int points, int n, const double *reference,
                            const double *inverse, const double *weights, const int32_t *nodes,
                            const double *P, double *force)
{
  for (int64_t e = 0; e < count; ++e) {
    double own[3 * MOST] = {0};
    for (int q = 0; q < points; ++q) {
      const int64_t at = e * points + q;
      const double *d = reference + 3 * q * n, *inv = inverse + 9 * at, *stress = P + 9 * at;
      double pulled[9];
      for (int i = 0; i < 3; ++i)
        for (int l = 0; l < 3; ++l)
          pulled[3 * i + l] = weights[at]
                              * (stress[3 * i] * inv[3 * l] + stress[3 * i + 1] * inv[3 * l + 1]
                                 + stress[3 * i + 2] * inv[3 * l + 2]);
      for (int a = 0; a < n; ++a)
        for (int i = 0; i < 3; ++i)
          own[3 * a + i] += pulled[3 * i] * d[3 * a] + pulled[3 * i + 1] * d[3 * a + 1]
                            + pulled[3 * i + 2] * d[3 * a + 2];
    }
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < 3; ++i)
        force[3 * (int64_t)nodes[e * n + a] + i] += own[3 * a + i];
  }
}

/* Blocks of the tangent A; `n` is known where this is used, and the loops over nodes are unrolled. */
static inline __attribute__((always_inline)) void
add_tangents(const int n, int64_t count, int points, const double *reference, const double *inverse,
             const double *weights, const int32_t *positions, const double *A, double *values)
{
  for (int64_t e = 0; e < count; ++e) {
    double K[MOST][9][MOST];
    for (int a = 0; a < n; ++a)
      for (int m = 0; m < 9; ++m)
        for (int b = 0; b < n; ++b)
          K[a][m][b] = 0.0;
    for (int q = 0; q < points; ++q) {
      const int64_t at = e * points + q;
      const double *d = reference + 3 * q * n, *inv = inverse + 9 * at, *tangent = A + 81 * at;
      double G[3][MOST], H[27][MOST];
      for (int b = 0; b < n; ++b)
        for (int j = 0; j < 3; ++j)
          G[j][b] = d[3 * b] * inv[j] + d[3 * b + 1] * inv[3 + j] + d[3 * b + 2] * inv[6 + j];
      for (int m = 0; m < 27; ++m)
        for (int b = 0; b < n; ++b)
          H[m][b] = tangent[3 * m] * G[0][b] + tangent[3 * m + 1] * G[1][b]
                    + tangent[3 * m + 2] * G[2][b];
      for (int a = 0; a < n; ++a) {
        const double x = weights[at] * G[0][a], y = weights[at] * G[1][a], z = weights[at] * G[2][a];
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k)
            for (int b = 0; b < n; ++b)
              K[a][3 * i + k][b] += x * H[9 * i + k][b] + y * H[9 * i + 3 + k][b]
                                    + z * H[9 * i + 6 + k][b];
      }
    }
    const int32_t *position = positions + e * n * n;
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        double *block = values + 9 * (int64_t)position[a * n + b];
        for (int m = 0; m < 9; ++m)
          block[m] += K[a][m][b];
      }
  }
}

void fenics_defo_add_tangents(int64_t count, int points, int n, const double *reference,
                              const double *inverse, const double *weights,
                              const int32_t *positions, const double *A, double *values)
{
  switch (n) {
  case 4:
    add_tangents(4, count, points, reference, inverse, weights, positions, A, values);
    break;
  case 8:
    add_tangents(8, count, points, reference, inverse, weights, positions, A, values);
    break;
  case 10:
    add_tangents(10, count, points, reference, inverse, weights, positions, A, values);
    break;
  default:
    add_tangents(n, count, points, reference, inverse, weights, positions, A, values);
  }
}

/* Add given blocks. */
void fenics_defo_add_blocks(int64_t count, const int32_t *positions, const double *blocks,
                            double *values)
{
  for (int64_t e = 0; e < count; ++e)
    for (int m = 0; m < 9; ++m)
      values[9 * (int64_t)positions[e] + m] += blocks[9 * e + m];
}

/* Inverses of 3x3 blocks by their cofactors; not finite where there is none. */
void fenics_defo_invert_blocks(int64_t count, const double *blocks, double *inverses)
{
  for (int64_t e = 0; e < count; ++e) {
    const double *m = blocks + 9 * e;
    double *out = inverses + 9 * e;
    const double x = m[4] * m[8] - m[5] * m[7], y = m[5] * m[6] - m[3] * m[8],
                 z = m[3] * m[7] - m[4] * m[6];
    const double scale = 1.0 / (m[0] * x + m[1] * y + m[2] * z);
    out[0] = scale * x;
    out[1] = scale * (m[2] * m[7] - m[1] * m[8]);
    out[2] = scale * (m[1] * m[5] - m[2] * m[4]);
    out[3] = scale * y;
    out[4] = scale * (m[0] * m[8] - m[2] * m[6]);
    out[5] = scale * (m[2] * m[3] - m[0] * m[5]);
    out[6] = scale * z;
    out[7] = scale * (m[1] * m[6] - m[0] * m[7]);
    out[8] = scale * (m[0] * m[4] - m[1] * m[3]);
  }
}

/* Copy blocks, or add them, to PETSc's, which are stored column by column. */
void fenics_defo_write_blocks(int64_t count, const int32_t *from, const double *values, int add,
                              double *target)
{
  for (int64_t e = 0; e < count; ++e) {
    const double *block = values + 9 * (int64_t)from[e];
    double *out = target + 9 * e;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        out[3 * k + i] = block[3 * i + k] + (add ? out[3 * k + i] : 0.0);
  }
}
