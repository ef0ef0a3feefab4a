/* The few functions of OpenMP that gcc calls for smidgen's threads, over pthreads: ThreadSanitizer knows those, and does not see how a library
 * that was built without it makes its threads wait for each other. Linked before that library. */
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

typedef struct team {
  pthread_barrier_t all;
  pthread_mutex_t lock;
  long next, end, step, chunk;
  int threads, ended;
} team;

typedef struct member {
  team *of;
  void (*run)(void *);
  void *data;
  int number;
} member;

static __thread member *me;
static pthread_mutex_t critical = PTHREAD_MUTEX_INITIALIZER;

int omp_get_thread_num(void) { return me ? me->number : 0; }
int omp_get_num_threads(void) { return me ? me->of->threads : 1; }
int omp_get_max_threads(void) {
  const char *said = getenv("OMP_NUM_THREADS");
  return said ? atoi(said) : 1;
}

static void *begin(void *of) {
  me = of;
  me->run(me->data);
  me = NULL;
  return NULL;
}

void GOMP_parallel(void (*run)(void *), void *data, unsigned threads, unsigned flags) {
  (void)flags;
  member *members = malloc(threads * sizeof *members);
  pthread_t *others = malloc(threads * sizeof *others);
  team one = {.threads = (int)threads, .ended = (int)threads};
  pthread_barrier_init(&one.all, NULL, threads);
  pthread_mutex_init(&one.lock, NULL);
  for (unsigned k = 0; k < threads; ++k) members[k] = (member){&one, run, data, (int)k};
  for (unsigned k = 1; k < threads; ++k) pthread_create(others + k, NULL, begin, members + k);
  begin(members);
  for (unsigned k = 1; k < threads; ++k) pthread_join(others[k], NULL);
  pthread_mutex_destroy(&one.lock);
  pthread_barrier_destroy(&one.all);
  free(others);
  free(members);
}

void GOMP_critical_start(void) { pthread_mutex_lock(&critical); }
void GOMP_critical_end(void) { pthread_mutex_unlock(&critical); }

bool GOMP_loop_nonmonotonic_dynamic_next(long *from, long *to) {
  team *t = me->of;
  pthread_mutex_lock(&t->lock);
  *from = t->next;
  *to = *from + t->chunk < t->end ? *from + t->chunk : t->end;
  t->next = *to;
  pthread_mutex_unlock(&t->lock);
  return *from < *to;
}

/* The first of a team that comes to a loop says what it is. */
bool GOMP_loop_nonmonotonic_dynamic_start(long from, long to, long step, long chunk, long *first, long *last) {
  team *t = me->of;
  pthread_mutex_lock(&t->lock);
  if (t->ended == t->threads) {
    t->next = from;
    t->end = to;
    t->chunk = chunk * step;
    t->ended = 0;
  }
  pthread_mutex_unlock(&t->lock);
  return GOMP_loop_nonmonotonic_dynamic_next(first, last);
}

static void ended(team *t) {
  pthread_mutex_lock(&t->lock);
  ++t->ended;
  pthread_mutex_unlock(&t->lock);
}

void GOMP_loop_end_nowait(void) { ended(me->of); }

void GOMP_loop_end(void) {
  team *t = me->of;
  ended(t);
  pthread_barrier_wait(&t->all);
}
