/* Systems by products alone, of a matrix that is written down. In: n, tolerance, A (n*n), b (n). Out: status and x of A x = b; is A
 * coercive, and the sign of det A, its spread taken as 2; vectors of the basis for 10 n and 100 n unknowns, and numbers of room for n. */
#include "pipe.h"
#include "smg_krylov.h"

typedef struct matrix {
  int64_t n;
  const smg_real *A;
} matrix;

static void times(void *of, const smg_real *x, smg_real *y) {
  const matrix *m = (const matrix *)of;
  for (int64_t i = 0; i < m->n; ++i) y[i] = smg_krylov_dot(m->n, m->A + m->n * i, x);
}

int main(void) {
  const int64_t n = pipe_integer();
  const smg_real tolerance = (smg_real)pipe_number();
  const int64_t room = (int64_t)smg_krylov_worksize(n);
  smg_real *A = pipe_room(n * n), *x = pipe_room(n), *work = pipe_room(room);
  pipe_take(n * n, A);
  pipe_take(n, x);
  matrix m = {n, A};
  const smg_krylov a = {&m, times, n, work};
  pipe_put(smg_krylov_solve(&a, x, tolerance, SMG_KRYLOV_PRODUCTS));
  pipe_give(n, x);
  pipe_put(smg_krylov_coercive(&a, 2));
  pipe_put(smg_krylov_sign(&a, &a, 2));
  pipe_put(smg_krylov_basis(10 * n));
  pipe_put(smg_krylov_basis(100 * n));
  pipe_put((double)room);
  free(A), free(x), free(work);
  return 0;
}
