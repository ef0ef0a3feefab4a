/* Put before the MPI library (LD_PRELOAD): messages begin and end late, and tests for them say "not yet", at random by LATE_SEED.
 *
 * A message is received into a buffer of this file. Until its request is completed by a wait, or by a test that says so, the
 * receiver's own buffer holds NaN: whoever reads it too early reads that. What is sent is copied when the message begins, and compared
 * with the sender's buffer when it is completed: whoever writes to it too early ends the run. So does whoever begins a message that is
 * still under way. */
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

static void end(const char *said) {
  fprintf(stderr, "late_messages: %s\n", said);
  MPI_Abort(MPI_COMM_WORLD, 3);
}

/* One request: the caller's buffer, and the packed copy that travels. */
typedef struct message {
  MPI_Request request;
  void *buffer;
  char *packed, *again;
  int count, size, receives, persistent, active;
  MPI_Datatype type;
} message;

#define MOST 4096
static message all[MOST];
static int used, begins;

static message *of(MPI_Request r) {
  for (int k = 0; k < used; ++k)
    if (all[k].request == r) return all + k;
  return NULL;
}

static void pack(const message *m, char *to) {
  int at = 0;
  PMPI_Pack(m->buffer, m->count, m->type, to, m->size, &at, MPI_COMM_WORLD);
}

static void unpack(const message *m) {
  int at = 0;
  PMPI_Unpack(m->packed, m->size, &at, m->buffer, m->count, m->type, MPI_COMM_WORLD);
}

static message *noted(const void *buffer, int count, MPI_Datatype type, int receives, int persistent) {
  if (used == MOST) end("too many requests");
  message *m = all + used++;
  *m = (message){.buffer = (void *)(uintptr_t)buffer, .count = count, .receives = receives, .persistent = persistent};
  PMPI_Type_dup(type, &m->type);
  PMPI_Pack_size(count, type, MPI_COMM_WORLD, &m->size);
  m->packed = malloc((size_t)m->size + 1);
  m->again = malloc((size_t)m->size + 1);
  return m;
}

static void dropped(message *m) {
  PMPI_Type_free(&m->type);
  free(m->packed);
  free(m->again);
  *m = all[--used];
}

/* The message begins: NaN where it will be, or a copy of what it says. */
static void begun(message *m) {
  if (m->active) end("a message begins that is still under way");
  m->active = 1;
  ++begins;
  if (m->receives) memset(m->packed, 0xff, (size_t)m->size);
  if (m->receives) unpack(m);
  else pack(m, m->packed);
}

/* It is completed. */
static void done(message *m) {
  if (!m->active) return;
  m->active = 0;
  if (m->receives) unpack(m);
  else pack(m, m->again);
  if (!m->receives && memcmp(m->packed, m->again, (size_t)m->size)) end("a buffer was written to before its message had gone");
  if (!m->persistent) dropped(m);
}

int MPI_Recv_init(void *into, int n, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request *r) {
  message *m = noted(into, n, type, 1, 1);
  const int status = PMPI_Recv_init(m->packed, m->size, MPI_PACKED, from, tag, comm, r);
  m->request = *r;
  return status;
}
int MPI_Send_init(const void *from, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request *r) {
  message *m = noted(from, n, type, 0, 1);
  const int status = PMPI_Send_init(m->packed, m->size, MPI_PACKED, to, tag, comm, r);
  m->request = *r;
  return status;
}
int MPI_Isend(const void *from, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request *r) {
  message *m = noted(from, n, type, 0, 0);
  late();
  begun(m);
  const int status = PMPI_Isend(m->packed, m->size, MPI_PACKED, to, tag, comm, r);
  m->request = *r;
  return status;
}
int MPI_Irecv(void *into, int n, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request *r) {
  message *m = noted(into, n, type, 1, 0);
  late();
  begun(m);
  const int status = PMPI_Irecv(m->packed, m->size, MPI_PACKED, from, tag, comm, r);
  m->request = *r;
  return status;
}
int MPI_Request_free(MPI_Request *r) {
  message *m = of(*r);
  if (m && m->active) end("a request is freed whose message is under way");
  if (m) dropped(m);
  return PMPI_Request_free(r);
}
/* One by one, the last one first: messages overtake each other. */
int MPI_Startall(int n, MPI_Request *r) {
  int status = MPI_SUCCESS;
  while (n-- > 0 && status == MPI_SUCCESS) {
    late();
    begun(of(r[n]));
    status = PMPI_Start(r + n);
  }
  return status;
}

/* Of these requests, as they were before the call that completes them. */
static void done_all(int n, const MPI_Request *before) {
  for (int k = 0; k < n; ++k) {
    message *m = before[k] == MPI_REQUEST_NULL ? NULL : of(before[k]);
    if (m) done(m);
  }
}
int MPI_Waitall(int n, MPI_Request *r, MPI_Status *s) {
  MPI_Request before[MOST];
  late();
  memcpy(before, r, (size_t)n * sizeof *r);
  const int status = PMPI_Waitall(n, r, s);
  done_all(n, before);
  return status;
}
int MPI_Testall(int n, MPI_Request *r, int *flag, MPI_Status *s) {
  MPI_Request before[MOST];
  *flag = 0;
  if (drawn(2)) return MPI_SUCCESS;
  memcpy(before, r, (size_t)n * sizeof *r);
  const int status = PMPI_Testall(n, r, flag, s);
  if (*flag) done_all(n, before);
  return status;
}
/* How many messages there were is said at the end. */
int MPI_Finalize(void) {
  fprintf(stderr, "late_messages: %d\n", begins);
  return PMPI_Finalize();
}
int MPI_Sendrecv(const void *out, int n, MPI_Datatype type, int to, int tag, void *in, int m, MPI_Datatype kind, int from, int mark,
                 MPI_Comm comm, MPI_Status *s) {
  late();
  return PMPI_Sendrecv(out, n, type, to, tag, in, m, kind, from, mark, comm, s);
}
int MPI_Allreduce(const void *from, void *into, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  late();
  return PMPI_Allreduce(from, into, n, type, op, comm);
}
