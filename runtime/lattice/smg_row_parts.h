/* smidgen runtime: ranks with memory of their own (SMG_DISTRIBUTED, -DSMG_MPI): of all arrays a rank uses only what
 * belongs to its part and to the ends of others that its part feels.
 *
 * Addresses are those of one rank, and so are indices, code and bits: memory that nothing touches is none, as systems
 * give it page by page. Parts are layers of the slowest direction, so that the slots of a rank hold a run of sites,
 * smg_own. Between calls w has those sites, and as many before and after them as terms reach (SMG_PARTS_REACH layers).
 * Sums go from rank to rank in the order of the sites, to the bits of one rank. */
#ifndef SMG_ROW_PARTS_H
#define SMG_ROW_PARTS_H

#include "smg_own.h"
#include "smg_row_ranks.h"

#if SMG_IN_PARTS
#if defined(__linux__)
#include <sys/mman.h>
#endif

static int smg_is_divided(void) { return smg_mpi_parts > 1; }

#if SMG_GRID
/* Are there as many layers for each rank as sums reach? */
static inline int smg_may_divide(const smg_coefficients *c) {
  const int64_t least = smg_cells(c, SMG_SLOWEST) / smg_mpi_size;
  return SMG_SLOWEST > 0 && least >= 1 && least >= SMG_PARTS_REACH;
}
#else
/* Do slots follow the layers that loops over cells go through last? */
static inline int smg_may_divide(const smg_coefficients *c) {
  return smg_slowest(c) == SMG_SLOWEST && smg_mpi_layer(c) > 0;
}
#endif

/* Sites of a layer. */
static inline int64_t smg_layer_sites(const smg_coefficients *c) {
  int64_t sites = SMG_PLACES;
  for (int d = 0; d < SMG_SLOWEST; ++d) sites *= smg_cells(c, d);
  return sites;
}

#if SMG_GRID
/* The layers of a rank, as slots and as sites. */
static smg_box smg_layers_of(const smg_coefficients *c, int64_t rank) {
  smg_box b = {{0}, {smg_extent(c, 0), smg_extent(c, 1), smg_extent(c, 2), smg_extent(c, 3)}};
  b.from[SMG_SLOWEST] = smg_extent(c, SMG_SLOWEST) * rank / smg_mpi_parts;
  b.to[SMG_SLOWEST] = smg_extent(c, SMG_SLOWEST) * (rank + 1) / smg_mpi_parts;
  return b;
}
static int64_t smg_first_site(const smg_coefficients *c, int64_t rank) {
  return smg_layers_of(c, rank).from[SMG_SLOWEST] * smg_layer_sites(c);
}
#else
/* Where the sites of a rank begin: a slot of one direction alone is a site of each colour. */
static int64_t smg_first_site(const smg_coefficients *c, int rank) {
  const int64_t sites = SMG_SLOWEST > 0 ? smg_layer_sites(c) : SMG_PLACES * SMG_ROW_STEP;
  return rank < smg_mpi_parts ? smg_mpi_from(c, rank) / smg_mpi_layer(c) * sites : smg_sites(c);
}
#endif
static void smg_choose_sites(const smg_coefficients *c) {
  smg_own.from = smg_mpi_parts > 1 ? smg_first_site(c, smg_mpi_me) : 0;
  smg_own.to = smg_mpi_parts > 1 ? smg_first_site(c, smg_mpi_me + 1) : smg_sites(c);
}

/* A visit of the cells of one row from x on, before the end-th: all places, of each what there is of every colour. */
SMG_INLINE void smg_each_of_row(const smg_coefficients *c, int64_t row, int64_t x, int64_t end, void *context,
                                void (*visit)(void *context, int64_t site, int64_t slot)) {
  const int64_t n1 = smg_cells(c, 1), n2 = smg_cells(c, 2), s1 = row % n1, s2 = row / n1 % n2, s3 = row / n1 / n2,
                first = row * smg_cells(c, 0);
  for (int64_t sub = 0; sub < SMG_PLACES; ++sub)
    for (int64_t s0 = x; s0 < x + SMG_ROW_STEP && s0 < end; ++s0) {
      const int64_t start = smg_row_start(c, smg_colour_of(sub, s0, s1, s2, s3), sub, s1, s2, s3) + s0 / SMG_ROW_STEP,
                    sites = (end - s0 + SMG_ROW_STEP - 1) / SMG_ROW_STEP, site = (first + s0) * SMG_PLACES + sub;
      for (int64_t j = 0; j < sites; ++j) visit(context, site + SMG_ROW_STEP * SMG_PLACES * j, start + j);
    }
}
/* Of all sites of this rank. */
SMG_INLINE void smg_each_own_slot(const smg_coefficients *c, void *context,
                                  void (*visit)(void *context, int64_t site, int64_t slot)) {
  const int64_t n0 = smg_cells(c, 0), end = smg_own.to / SMG_PLACES;
  for (int64_t next, cell = smg_own.from / SMG_PLACES; cell < end; cell = next) {
    const int64_t row = cell / n0, first = row * n0;
    next = first + n0;
    smg_each_of_row(c, row, cell - first, (next < end ? next : end) - first, context, visit);
  }
}

/* Memory in whole pages within some numbers: of 2 MB where there are such pages (madvise), or given back, to be 0. */
static void smg_advise(SMG_UNUSED const smg_real *first, SMG_UNUSED int64_t numbers, SMG_UNUSED uintptr_t page,
                       SMG_UNUSED int advice) {
#if defined(MADV_HUGEPAGE)
  const uintptr_t from = ((uintptr_t)first + page - 1) / page * page, to = (uintptr_t)(first + numbers) / page * page;
  if (from < to) (void)madvise((void *)from, (size_t)(to - from), advice);
#endif
}
#if !defined(MADV_HUGEPAGE)
#define MADV_HUGEPAGE 0
#define MADV_DONTNEED 0
#endif

/* Before w is written by sites, or midpoints by slots, into the array that both use: the pages of the other. */
static void smg_release_other(const smg_state *s) {
  if (smg_mpi_parts > 1) smg_advise(s->w, smg_array_size(&s->c), 4096, MADV_DONTNEED);
}

/* Numbers that are 0 already are not touched. */
static void smg_zero_again(smg_real *first, int64_t numbers) {
  static const smg_real none[512] = {0};
  for (int64_t n, k = 0; k < numbers; k += n) {
    n = numbers - k < 512 ? numbers - k : 512;
    if (memcmp(first + k, none, sizeof none[0] * (size_t)n)) smg_zero(first + k, n);
  }
}

static void smg_clear_share(smg_real *array, int64_t pitch, smg_share part) {
  for (int k = 0; k < 3; ++k) {
    smg_real *slots = array + k * pitch + part.from;
    smg_advise(slots, part.to - part.from, (uintptr_t)1 << 21, MADV_HUGEPAGE);
    smg_zero_again(slots, part.to - part.from);
  }
}

/* This rank's slots of an array, 0; those of the colours from one on alone, where it has no others. */
static void smg_clear_slots(const smg_coefficients *c, smg_real *array, int64_t pitch, int64_t colour, int64_t end) {
  for (const int64_t first = colour * smg_colour_slots(c); colour < end; ++colour) {
#if SMG_GRID
    SMG_STRIPS(c, strip) smg_clear_share(array - first, pitch, smg_strip_of_rank(c, colour, 1, strip));
#else
    const smg_share all = {colour * smg_colour_slots(c), (colour + 1) * smg_colour_slots(c)};
    smg_clear_share(array - first, pitch, smg_part_of_rank(c, all));
#endif
  }
}

/* Sites before and after those of this rank, from the ranks that have them; the first rank and the last are
 * neighbours. */
static void smg_share_ends(const smg_coefficients *c, smg_real *w) {
  const int64_t far = SMG_PARTS_REACH * smg_layer_sites(c), all = smg_sites(c);
  const int n = smg_mpi_parts, before = (smg_mpi_me + n - 1) % n, after = (smg_mpi_me + 1) % n, size = (int)(3 * far);
  if (n == 1 || smg_mpi_me >= n || far == 0) return;
  MPI_Sendrecv(w + 3 * smg_own.from, size, SMG_MPI_REAL, before, 0, w + 3 * (smg_own.to % all), size, SMG_MPI_REAL,
               after, 0, SMG_MPI_COMM, MPI_STATUS_IGNORE);
  MPI_Sendrecv(w + 3 * (smg_own.to - far), size, SMG_MPI_REAL, after, 1,
               w + 3 * ((smg_own.from > 0 ? smg_own.from : all) - far), size, SMG_MPI_REAL, before, 1, SMG_MPI_COMM,
               MPI_STATUS_IGNORE);
}

/* The status of the first site that is refused, on all ranks. */
static smg_status smg_status_of_ranks(smg_status status, int64_t *site) {
  const int64_t mine = status == SMG_OK ? INT64_MAX : *site;
  int64_t least = mine;
  if (smg_mpi_parts == 1) return status;
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_INT64_T, MPI_MIN, SMG_MPI_COMM);
  int found = mine == least ? (int)status : 0;
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_MAX, SMG_MPI_COMM);
  *site = found ? least : -1;
  return (smg_status)found;
}

/* The number after the k-th of a saved state that is this rank's: behind the head w follows, and arrays as large. */
static size_t smg_next_saved(const smg_coefficients *c, size_t k, size_t head) {
  const size_t n3 = (size_t)(3 * smg_sites(c)), from = (size_t)(3 * smg_own.from), to = (size_t)(3 * smg_own.to);
  if (++k < head) return k;
  const size_t at = (k - head) % n3, array = k - at;
  return at < from ? array + from : at < to ? k : array + n3 + from;
}

/* A sum goes on where the rank before has come to; the last rank tells what it is. */
static void smg_sum_go_on(smg_sum *sum) {
  if (smg_mpi_me > 0 && smg_mpi_me < smg_mpi_parts)
    MPI_Recv(sum, (int)sizeof *sum, MPI_BYTE, smg_mpi_me - 1, 2, SMG_MPI_COMM, MPI_STATUS_IGNORE);
}
static smg_real smg_sum_of_ranks(smg_sum *sum) {
  if (smg_mpi_me + 1 < smg_mpi_parts) MPI_Send(sum, (int)sizeof *sum, MPI_BYTE, smg_mpi_me + 1, 2, SMG_MPI_COMM);
  smg_real found = smg_sum_of(sum);
  if (smg_mpi_parts > 1) MPI_Bcast(&found, 1, SMG_MPI_REAL, smg_mpi_parts - 1, SMG_MPI_COMM);
  return found;
}

#endif
#endif
