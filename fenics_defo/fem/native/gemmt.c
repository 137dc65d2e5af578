/* Triangular update C := alpha op(A) op(B) + beta C, one triangle only, by blocked calls of gemm.
 *
 * MUMPS spends most of a symmetric factorisation in this routine. OpenBLAS (0.3.32) provides it as one
 * gemv a column, bound by memory; blocks of gemm run at the processor's speed. Interface: the `?gemmt`
 * extension of the BLAS, Fortran calling convention, 32-bit integers; in double and in single precision.
 */
enum { BLOCK = 96 };

#define GEMMT(name, real, gemm, setter)                                                            \
  typedef void (*gemm##_t)(const char *, const char *, const int *, const int *, const int *,      \
                           const real *, const real *, const int *, const real *, const int *,     \
                           const real *, real *, const int *);                                     \
  static gemm##_t gemm = 0;                                                                        \
  void setter(void *address) { gemm = (gemm##_t)address; }                                         \
                                                                                                   \
  void name(const char *uplo, const char *transa, const char *transb, const int *n, const int *k,  \
            const real *alpha, const real *a, const int *lda, const real *b, const int *ldb,       \
            const real *beta, real *c, const int *ldc)                                             \
  {                                                                                                \
    const int upper = *uplo == 'U' || *uplo == 'u';                                                \
    const int a_plain = *transa == 'N' || *transa == 'n';                                          \
    const int b_plain = *transb == 'N' || *transb == 'n';                                          \
    const real zero = 0;                                                                           \
    real square[BLOCK * BLOCK]; /* on the stack: several threads may factorise at once */          \
                                                                                                   \
    for (int first = 0; first < *n; first += BLOCK) {                                              \
      const int width = *n - first < BLOCK ? *n - first : BLOCK;                                   \
      const int row = upper ? 0 : first + width;                                                   \
      const int rows = upper ? first : *n - first - width;                                         \
      const real *b_columns = b_plain ? b + (long)first * *ldb : b + first;                        \
      const real *a_rows = a_plain ? a + row : a + (long)row * *lda;                               \
      const real *a_square = a_plain ? a + first : a + (long)first * *lda;                         \
                                                                                                   \
      if (rows > 0)                                                                                \
        gemm(transa, transb, &rows, &width, k, alpha, a_rows, lda, b_columns, ldb, beta,           \
             c + row + (long)first * *ldc, ldc);                                                   \
      gemm(transa, transb, &width, &width, k, alpha, a_square, lda, b_columns, ldb, &zero, square, \
           &width);                                                                                \
      for (int j = 0; j < width; ++j) {                                                            \
        real *column = c + first + (long)(first + j) * *ldc;                                       \
        const real *update = square + j * width;                                                   \
        const int begin = upper ? 0 : j, end = upper ? j + 1 : width;                              \
        /* beta = 0 must overwrite, whatever C holds (it may be NaN) */                            \
        if (*beta == 0)                                                                            \
          for (int i = begin; i < end; ++i) column[i] = update[i];                                 \
        else                                                                                       \
          for (int i = begin; i < end; ++i) column[i] = *beta * column[i] + update[i];             \
      }                                                                                            \
    }                                                                                              \
  }

GEMMT(dgemmt_, double, dgemm, fenics_defo_set_dgemm)
GEMMT(sgemmt_, float, sgemm, fenics_defo_set_sgemm)
