/* smidgen runtime: when an iteration in lanes has come to rest, by the rate at which its changes shrink. */
#ifndef SMG_REST_H
#define SMG_REST_H

#include "smg_rules.h"

/* One quantity on its way to rest: its last change, the factor by which they shrink, and what is left of it beside
 * round-off. */
typedef struct smg_rest {
  smg_real now, rate, left;
  int stays; /* is the change round-off, and shrinks no more? */
  int still; /* so many changes in succession were round-off */
} smg_rest;

static const smg_rest smg_unknown_rest = {SMG_MAX, 1, SMG_MAX, 0, 0};

/* After so many changes that were round-off, one that did not shrink is enough. Where damped spins are at rest all
 * sweeps round alike, and changes alternate with the colours: one quantity shrinks in each pass in which the other does
 * not. */
#define SMG_LONG_STILL 8

/* The next change. Below some ulps it may be round-off: then the factor before tells what is left. */
static inline void smg_rest_take(smg_rest *rest, smg_real change, int still) {
  const smg_real rate = rest->now < SMG_MAX && change < rest->now ? change / rest->now : 1;
  rest->left = still ? smg_min(change, rest->rate * rest->now) : change;
  if (!still || rest->now >= SMG_MAX || rest->rate >= 1) rest->rate = rate;
  rest->still = still ? rest->still + 1 : 0;
  rest->stays = (still && rest->now < SMG_MAX && rate >= SMG_SLOWED) || (rest->stays && rest->still > SMG_LONG_STILL);
  rest->now = change;
}

/* Has it settled? The next change would be a small part of an ulp, since what is left of it is of one sign along many
 * an orbit; or the change is round-off and shrinks no more. */
static inline int smg_rest_settled(const smg_rest *rest, smg_real ulp) {
  return rest->rate * rest->left <= SMG_LEFT * ulp || rest->stays;
}

#endif
