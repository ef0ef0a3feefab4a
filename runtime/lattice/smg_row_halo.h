/* smidgen runtime: what the sites of a rank feel of other ranks (smg_row_ranks.h), and the messages that bring it.
 *
 * A part follows the slowest direction, so what another rank reads of it lies near its ends: so many slots from its
 * beginning and so many to its end, the same of x, y and z. Every rank finds what it reads of others, row by row, and
 * tells them; who reads is read, for neighbours feel each other. One message goes each way once those ends of a colour
 * are turned, and is on its way while the others are; requests are made once a call. */
#ifndef SMG_ROW_HALO_H
#define SMG_ROW_HALO_H

#include "smg_row_ranks.h"

#if defined(SMG_MPI)

#ifdef SMG_MPI_GRID
#include "smg_row_faces.h"
#else
/* Ranks that one can have to do with: two; where a colour has several places in a cell, up to four of each place before
 * and after and as many around a ring. */
#define SMG_MPI_PARTNERS (16 * SMG_RANKS)

/* Slots of each colour from the beginning of a part, and to its end. */
typedef struct smg_mpi_ends {
  int64_t first[SMG_COLOURS], last[SMG_COLOURS];
} smg_mpi_ends;

typedef struct smg_mpi_partner {
  int rank;
  smg_mpi_ends read, told; /* by this rank of its part, and by it of this rank's */
} smg_mpi_partner;

typedef struct smg_mpi_halo {
  int partners, messages[SMG_COLOURS];
  int64_t first[SMG_COLOURS], last[SMG_COLOURS]; /* slots that others read, in whole vectors */
  smg_mpi_partner with[SMG_MPI_PARTNERS];
  MPI_Request message[SMG_COLOURS][2 * SMG_MPI_PARTNERS];
} smg_mpi_halo;

static smg_mpi_halo smg_halo;

static smg_mpi_partner *smg_mpi_with(int rank) {
  const smg_mpi_partner found = {rank, {{0}, {0}}, {{0}, {0}}};
  for (int k = 0; k < smg_halo.partners; ++k)
    if (smg_halo.with[k].rank == rank) return smg_halo.with + k;
  if (smg_halo.partners == SMG_MPI_PARTNERS) MPI_Abort(SMG_MPI_COMM, 1);
  smg_halo.with[smg_halo.partners] = found;
  return smg_halo.with + smg_halo.partners++;
}

/* The slots from <= k < to of a row are read. */
static void smg_mpi_reads(const smg_coefficients *c, int64_t from, int64_t to) {
  while (from < to) {
    const int64_t colour = from / smg_colour_slots(c), first = colour * smg_colour_slots(c);
    const int owner = smg_mpi_owner(c, from);
    const int64_t begin = first + smg_mpi_from(c, owner), end = first + smg_mpi_from(c, owner + 1),
                  upto = to < end ? to : end;
    if (owner != smg_mpi_me) {
      smg_mpi_ends *read = &smg_mpi_with(owner)->read;
      int64_t *ends = upto - begin <= end - from ? read->first : read->last,
              slots = upto - begin <= end - from ? upto - begin : end - from;
      if (slots > ends[colour]) ends[colour] = slots;
    }
    from = upto;
  }
}

/* What the sites from <= j < to of a row read. */
static void smg_mpi_row_reads(const smg_coefficients *c, const smg_lattice_row *at, const smg_beside *b, int64_t from,
                              int64_t to) {
  for (const smg_beside *end = b + SMG_BESIDES; b < end; ++b) {
    if (!b->there) continue;
    const int64_t start = at->start + b->start, around = at->start + b->around;
    smg_mpi_reads(c, start + (from > b->from ? from : b->from), start + (to < b->to ? to : b->to));
    if (!(SMG_RINGS & 1)) continue;
    smg_mpi_reads(c, around + from, around + (to < b->from ? to : b->from));
    if (b->to < to) smg_mpi_reads(c, around + (from > b->to ? from : b->to), around + to);
  }
}

/* What the part of this rank in a colour reads. */
static void smg_mpi_colour_reads(const smg_coefficients *c, smg_besides *known, int64_t colour) {
  const int64_t length = smg_row_length(c), end = colour * smg_colour_slots(c) + smg_mpi_from(c, smg_mpi_me + 1);
  int64_t j = smg_mpi_from(c, smg_mpi_me) % length;
  smg_lattice_row at = smg_row_of(c, colour, smg_mpi_from(c, smg_mpi_me) / length);
  for (; at.rank < SMG_RANKS && at.start + j < end; smg_next_row(c, length, &at)) {
    const int64_t left = end - at.start;
    smg_mpi_row_reads(c, &at, smg_besides_of(c, &at, known), j, left < at.sites ? left : at.sites);
    j = 0;
  }
}

/* Every partner hears what is read of it. */
static void smg_mpi_tell(void) {
  MPI_Request *asked = smg_halo.message[0];
  const int size = 2 * SMG_COLOURS;
  for (int k = 0; k < smg_halo.partners; ++k) {
    smg_mpi_partner *p = smg_halo.with + k;
    MPI_Isend(&p->read, size, MPI_INT64_T, p->rank, SMG_COLOURS, SMG_MPI_COMM, asked + 2 * k);
    MPI_Irecv(&p->told, size, MPI_INT64_T, p->rank, SMG_COLOURS, SMG_MPI_COMM, asked + 2 * k + 1);
  }
  MPI_Waitall(2 * smg_halo.partners, asked, MPI_STATUSES_IGNORE);
}

/* The ends of a rank's part in a colour as one thing to send; 0 where they are empty. */
static int smg_mpi_ends_type(const smg_coefficients *c, int rank, int64_t colour, const smg_mpi_ends *ends,
                             MPI_Datatype *type) {
  const int64_t first = colour * smg_colour_slots(c), begin = first + smg_mpi_from(c, rank),
                end = first + smg_mpi_from(c, rank + 1);
  const int whole = ends->first[colour] + ends->last[colour] > end - begin;
  const int64_t low = whole ? end - begin : ends->first[colour], high = whole ? 0 : ends->last[colour];
  int size[6];
  MPI_Aint at[6];
  for (int k = 0; k < 3; ++k) {
    size[2 * k] = (int)low;
    size[2 * k + 1] = (int)high;
    at[2 * k] = (MPI_Aint)((k * smg_pitch(c) + begin) * (int64_t)sizeof(smg_real));
    at[2 * k + 1] = (MPI_Aint)((k * smg_pitch(c) + end - high) * (int64_t)sizeof(smg_real));
  }
  if (low + high == 0) return 0;
  MPI_Type_create_hindexed(6, size, at, SMG_MPI_REAL, type);
  return MPI_Type_commit(type) == MPI_SUCCESS;
}

/* most = n or more, in whole vectors. */
static void smg_mpi_at_least(int64_t n, int64_t *most) {
  if (smg_whole_vectors(n) > *most) *most = smg_whole_vectors(n);
}

/* The messages of a colour's pass. */
static void smg_mpi_prepare(const smg_state *s, int64_t colour) {
  int *n = smg_halo.messages + colour;
  MPI_Request *message = smg_halo.message[colour];
  *n = 0;
  smg_halo.first[colour] = smg_halo.last[colour] = 0;
  for (const smg_mpi_partner *p = smg_halo.with; p < smg_halo.with + smg_halo.partners; ++p) {
    MPI_Datatype type;
    smg_mpi_at_least(p->told.first[colour], smg_halo.first + colour);
    smg_mpi_at_least(p->told.last[colour], smg_halo.last + colour);
    if (smg_mpi_ends_type(&s->c, p->rank, colour, &p->read, &type)) {
      MPI_Recv_init(s->row_m, 1, type, p->rank, (int)colour, SMG_MPI_COMM, message + (*n)++);
      MPI_Type_free(&type);
    }
    if (smg_mpi_ends_type(&s->c, smg_mpi_me, colour, &p->told, &type)) {
      MPI_Send_init(s->row_m, 1, type, p->rank, (int)colour, SMG_MPI_COMM, message + (*n)++);
      MPI_Type_free(&type);
    }
  }
}

/* A call begins, and ends. */
static void smg_begin_ranks(const smg_state *s, smg_besides *known) {
  smg_choose_ranks(&s->c);
  smg_halo.partners = 0;
  if (smg_mpi_parts > 1 && smg_mpi_me < smg_mpi_parts)
    for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) smg_mpi_colour_reads(&s->c, known, colour);
  if (smg_halo.partners > 0) smg_mpi_tell();
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) smg_mpi_prepare(s, colour);
}
#endif

/* Every rank does all of what follows. */
static void smg_by_each_rank(SMG_UNUSED const smg_coefficients *c) {
  smg_mpi_parts = 1;
#if SMG_GRID
  smg_stay_whole(c);
#endif
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour) smg_halo.messages[colour] = 0;
}

static void smg_end_ranks(const smg_state *s) {
  for (int64_t colour = 0; colour < SMG_COLOURS; ++colour)
    for (int k = 0; k < smg_halo.messages[colour]; ++k) MPI_Request_free(smg_halo.message[colour] + k);
  smg_gather_rows(s);
}

/* Midpoints of a colour. */
static void smg_send_colour(int64_t colour) {
  if (smg_halo.messages[colour] > 0) MPI_Startall(smg_halo.messages[colour], smg_halo.message[colour]);
}
static void smg_await_colour(int64_t colour) {
  if (smg_halo.messages[colour] > 0)
    MPI_Waitall(smg_halo.messages[colour], smg_halo.message[colour], MPI_STATUSES_IGNORE);
}

/* Large messages move only while MPI is called: so it is, after so many slots, some 0.1 ms of work, while there are
 * messages. */
#ifndef SMG_MPI_LOOK
#define SMG_MPI_LOOK 16384
#endif
static int64_t smg_mpi_looks(smg_share inner) {
  return smg_halo.partners > 0 && inner.to - inner.from > SMG_MPI_LOOK ? (inner.to - inner.from) / SMG_MPI_LOOK : 1;
}
static void smg_look_at_colour(int64_t colour) {
  int all = 0;
  if (smg_halo.messages[colour] > 0)
    MPI_Testall(smg_halo.messages[colour], smg_halo.message[colour], &all, MPI_STATUSES_IGNORE);
}

#if !SMG_GRID
/* Of this rank's slots, those that no other one reads. */
static smg_share smg_between_ends(int64_t colour, smg_share all) {
  const int64_t first = smg_halo.first[colour], last = smg_halo.last[colour];
  const smg_share inner = {all.from + first, all.to - last}, none = {all.to, all.to};
  return first + last < all.to - all.from ? inner : none;
}
#endif

/* Those that were predicted: of all colours but the first. */
static void smg_exchange_late(void) {
  for (int64_t colour = 1; colour < SMG_COLOURS; ++colour) smg_send_colour(colour);
  for (int64_t colour = 1; colour < SMG_COLOURS; ++colour) smg_await_colour(colour);
}

#endif
#endif
