/* Strains that displacement fields and their pairs cause at quadrature points, as columns.
 *
 * Gradients are (fields, 3, 3, points), [i, a, b] = dU_ia / dX_b. Each strain takes six rows of
 * points in an orthonormal basis of symmetric tensors (xx, yy, zz, xy, yz, zx), multiplied with the
 * root of an isotropic Hooke's tensor: shear times the strain, plus spread times its trace on the
 * diagonal. A column holds the six rows of the first CHUNK points, then those of the next: what is
 * written at once lies together.
 */
#include <stdint.h>

enum { CHUNK = 64 }; /* points at once: their gradients stay in the second cache */

static const double HALF_ROOT = 0.70710678118654752440;

static int64_t least(int64_t a, int64_t b) { return a < b ? a : b; }

/* A chunk of the column of a field, e = sym D. */
static void field_strain(int64_t count, int64_t points, const double *restrict D,
                         const double *restrict shear, const double *restrict spread,
                         double *restrict out)
{
  for (int64_t k = 0; k < count; ++k) {
    const double xx = D[k], yy = D[4 * points + k], zz = D[8 * points + k];
    const double dilation = spread[k] * (xx + yy + zz), half = HALF_ROOT * shear[k];
    out[k] = shear[k] * xx + dilation;
    out[count + k] = shear[k] * yy + dilation;
    out[2 * count + k] = shear[k] * zz + dilation;
    out[3 * count + k] = half * (D[points + k] + D[3 * points + k]);
    out[4 * count + k] = half * (D[5 * points + k] + D[7 * points + k]);
    out[5 * count + k] = half * (D[6 * points + k] + D[2 * points + k]);
  }
}

/* A chunk of the column of a pair, n = sym(A^T B). */
static void pair_strain(int64_t count, int64_t points, const double *restrict A,
                        const double *restrict B, const double *restrict shear,
                        const double *restrict spread, double *restrict out)
{
#define at(M, a, b) M[(3 * (a) + (b)) * points + k]
#define product(b, c) (at(A, 0, b) * at(B, 0, c) + at(A, 1, b) * at(B, 1, c) + at(A, 2, b) * at(B, 2, c))
  for (int64_t k = 0; k < count; ++k) {
    const double xx = product(0, 0), yy = product(1, 1), zz = product(2, 2);
    const double dilation = spread[k] * (xx + yy + zz), half = HALF_ROOT * shear[k];
    out[k] = shear[k] * xx + dilation;
    out[count + k] = shear[k] * yy + dilation;
    out[2 * count + k] = shear[k] * zz + dilation;
    out[3 * count + k] = half * (product(0, 1) + product(1, 0));
    out[4 * count + k] = half * (product(1, 2) + product(2, 1));
    out[5 * count + k] = half * (product(2, 0) + product(0, 2));
  }
#undef product
#undef at
}

/* Columns of the fields, and, if wanted, of their pairs i <= j row by row. */
void fenics_defo_strain_columns(int64_t fields, int64_t points, int pairs, const double *gradients,
                                const double *shear, const double *spread, double *columns)
{
  for (int64_t first = 0; first < points; first += CHUNK) {
    const int64_t count = least(CHUNK, points - first);
    const double *D = gradients + first, *s = shear + first, *t = spread + first;
    double *out = columns + 6 * first;
    for (int64_t i = 0; i < fields; ++i, out += 6 * points)
      field_strain(count, points, D + 9 * points * i, s, t, out);
    for (int64_t i = 0; pairs && i < fields; ++i)
      for (int64_t j = i; j < fields; ++j, out += 6 * points)
        pair_strain(count, points, D + 9 * points * i, D + 9 * points * j, s, t, out);
  }
}
