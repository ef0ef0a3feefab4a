/* Put before the MPI library (LD_PRELOAD): messages begin and end late, and tests for them say "not yet", at random by LATE_SEED. */
#include <mpi.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>

/* xorshift64 of Marsaglia; another sequence in each process. */
static unsigned drawn(unsigned below) {
  static uint64_t x;
  const char *seed = getenv("LATE_SEED");
  if (!x) x = 88172645463325252u ^ ((uint64_t)getpid() << 20) ^ (uint64_t)atoll(seed ? seed : "1");
  x ^= x << 13;
  x ^= x >> 7;
  x ^= x << 17;
  return (unsigned)(x >> 33) % below;
}

static void late(void) {
  if (drawn(4) == 0) usleep(drawn(drawn(8) == 0 ? 5000 : 200));
}

int MPI_Isend(const void *from, int n, MPI_Datatype type, int to, int tag, MPI_Comm of, MPI_Request *r) {
  late();
  return PMPI_Isend(from, n, type, to, tag, of, r);
}
int MPI_Irecv(void *into, int n, MPI_Datatype type, int from, int tag, MPI_Comm of, MPI_Request *r) {
  late();
  return PMPI_Irecv(into, n, type, from, tag, of, r);
}
int MPI_Sendrecv(const void *out, int n, MPI_Datatype type, int to, int tag, void *in, int m, MPI_Datatype kind, int from, int mark,
                 MPI_Comm of, MPI_Status *s) {
  late();
  return PMPI_Sendrecv(out, n, type, to, tag, in, m, kind, from, mark, of, s);
}
int MPI_Start(MPI_Request *r) {
  late();
  return PMPI_Start(r);
}
/* One by one, the last one first: messages overtake each other. */
int MPI_Startall(int n, MPI_Request *r) {
  int status = MPI_SUCCESS;
  while (n-- > 0 && status == MPI_SUCCESS) status = MPI_Start(r + n);
  return status;
}
int MPI_Test(MPI_Request *r, int *done, MPI_Status *s) {
  *done = 0;
  return drawn(2) ? MPI_SUCCESS : PMPI_Test(r, done, s);
}
int MPI_Testall(int n, MPI_Request *r, int *done, MPI_Status *s) {
  *done = 0;
  return drawn(2) ? MPI_SUCCESS : PMPI_Testall(n, r, done, s);
}
int MPI_Wait(MPI_Request *r, MPI_Status *s) {
  late();
  return PMPI_Wait(r, s);
}
int MPI_Waitall(int n, MPI_Request *r, MPI_Status *s) {
  late();
  return PMPI_Waitall(n, r, s);
}
int MPI_Allreduce(const void *from, void *into, int n, MPI_Datatype type, MPI_Op op, MPI_Comm of) {
  late();
  return PMPI_Allreduce(from, into, n, type, op, of);
}
