/* Triangular update C := alpha op(A) op(B) + beta C, one triangle only, by blocked calls of dgemm.
 *
 * MUMPS spends most of a symmetric factorisation in this routine. OpenBLAS (0.3.32) provides it as one
 * dgemv a column, bound by memory; blocks of dgemm run at the processor's speed. Interface: the `?gemmt`
 * extension of the BLAS, Fortran calling convention, 32-bit integers.
 */
typedef void (*gemm_t)(const char *, const char *, const int *, const int *, const int *,
                       const double *, const double *, const int *, const double *, const int *,
                       const double *, double *, const int *);

static gemm_t gemm = 0;

void fenics_defo_set_dgemm(void *address) { gemm = (gemm_t)address; }

enum { BLOCK = 96 };

void dgemmt_(const char *uplo, const char *transa, const char *transb, const int *n, const int *k,
             const double *alpha, const double *a, const int *lda, const double *b, const int *ldb,
             const double *beta, double *c, const int *ldc)
{
  const int upper = *uplo == 'U' || *uplo == 'u';
  const int a_plain = *transa == 'N' || *transa == 'n';
  const int b_plain = *transb == 'N' || *transb == 'n';
  const double zero = 0.0;
  double square[BLOCK * BLOCK]; /* on the stack: several threads may factorise at once */

  for (int first = 0; first < *n; first += BLOCK) {
    const int width = *n - first < BLOCK ? *n - first : BLOCK;
    const int row = upper ? 0 : first + width;
    const int rows = upper ? first : *n - first - width;
    const double *b_columns = b_plain ? b + (long)first * *ldb : b + first;
    const double *a_rows = a_plain ? a + row : a + (long)row * *lda;
    const double *a_square = a_plain ? a + first : a + (long)first * *lda;

    if (rows > 0)
      gemm(transa, transb, &rows, &width, k, alpha, a_rows, lda, b_columns, ldb, beta,
           c + row + (long)first * *ldc, ldc);
    gemm(transa, transb, &width, &width, k, alpha, a_square, lda, b_columns, ldb, &zero, square,
         &width);
    for (int j = 0; j < width; ++j) {
      double *column = c + first + (long)(first + j) * *ldc;
      const double *update = square + j * width;
      const int begin = upper ? 0 : j, end = upper ? j + 1 : width;
      /* beta = 0 must overwrite, whatever C holds (it may be NaN) */
      if (*beta == 0.0)
        for (int i = begin; i < end; ++i) column[i] = update[i];
      else
        for (int i = begin; i < end; ++i) column[i] = *beta * column[i] + update[i];
    }
  }
}
