/* A queue between a writer and a reader: the places of IndexQueue as SFT replaces it, around the elements and
   the size of iceoryx's LockFreeQueue. Each memory access is a step of its own. A thread may take its steps in
   any order that C++ allows: what stands before a release, or behind an acquire, stays there, and nothing else
   is ordered. Each element that is taken is the one that was pushed, and the size is never below zero. See
   model.md.

   PUBLISHED_RELAXED, SEEN_RELAXED: as in iceoryx 2.0.x, for the filled places only; GIVEN_BACK_RELAXED: for
   the free ones. */

#define SAMPLES 4 /* each with steps of its own, below */
#define CAPACITY 2
#define BIT(n) (1 << (n))
#define UP_TO(n) (BIT((n) + 1) - 1) /* of the samples 0 to n */
#define PLACE(n) ((n) % CAPACITY)

/* The samples are numbered from 0 on. In memory they are 1 more: nothing is 0. */
byte element[CAPACITY];
byte used[CAPACITY];  /* the cell of the queue of filled places: which sample was put there last */
byte freed[CAPACITY]; /* that of the free places: how often the place was given back */
short size;

/* Which steps the writer has made: of sample n, bit n. */
byte found, written, counted, published;

/* May all steps that stand before be behind, for sample n? */
#define WRITTEN_BEFORE(n) ((written & UP_TO(n)) == UP_TO(n))
#define COUNTED_BEFORE(n) ((counted & UP_TO(n)) == UP_TO(n))
#define PUBLISHED_BEFORE(n) ((published & (UP_TO(n) >> 1)) == (UP_TO(n) >> 1))

inline write_steps(n) {
  if
  /* Pops a free place, acquired. All later steps of the writer wait for that. */
  :: !(found & BIT(n)) && found == BIT(n) - 1 && freed[PLACE(n)] == (n) / CAPACITY -> found = found | BIT(n)
  :: !(written & BIT(n)) && (found & BIT(n)) -> element[PLACE(n)] = n + 1; written = written | BIT(n)
  /* Adds to the size, with release. */
  :: !(counted & BIT(n)) && counted == BIT(n) - 1 && WRITTEN_BEFORE(n) ->
      size++;
      counted = counted | BIT(n)
#ifdef PUBLISHED_RELAXED
  :: !(published & BIT(n)) && (found & BIT(n)) ->
#else
  :: !(published & BIT(n)) && WRITTEN_BEFORE(n) && COUNTED_BEFORE(n) && PUBLISHED_BEFORE(n) ->
#endif
      used[PLACE(n)] = n + 1;
      published = published | BIT(n)
  fi
}

active proctype writer() {
  do
  :: published == UP_TO(SAMPLES - 1) && counted == published && written == published -> break
  :: atomic { write_steps(0) }
  :: atomic { write_steps(1) }
  :: atomic { write_steps(2) }
  :: atomic { write_steps(3) }
  od
}

byte seen, subtracted, read, returned;
byte got[SAMPLES];

#define SUBTRACTED_BEFORE(n) ((subtracted & UP_TO(n)) == UP_TO(n))
#define READ_BEFORE(n) ((read & UP_TO(n)) == UP_TO(n))
#define RETURNED_BEFORE(n) ((returned & (UP_TO(n) >> 1)) == (UP_TO(n) >> 1))
#ifdef SEEN_RELAXED
#define MAY_GO_ON(n) true /* by a guess, which comes true */
#else
#define MAY_GO_ON(n) ((seen & BIT(n)) != 0)
#endif

inline read_steps(n) {
  if
  /* Sees the filled place. */
  :: !(seen & BIT(n)) && seen == BIT(n) - 1 && used[PLACE(n)] == n + 1 -> seen = seen | BIT(n)
  /* Subtracts from the size, acquired. */
  :: !(subtracted & BIT(n)) && subtracted == BIT(n) - 1 && MAY_GO_ON(n) ->
      size--;
      subtracted = subtracted | BIT(n)
  :: !(read & BIT(n)) && (subtracted & BIT(n)) -> got[n] = element[PLACE(n)]; read = read | BIT(n)
  /* Gives the place back. No store is made on a guess. */
#ifdef GIVEN_BACK_RELAXED
  :: !(returned & BIT(n)) && (seen & BIT(n)) ->
#else
  :: !(returned & BIT(n)) && (seen & BIT(n)) && SUBTRACTED_BEFORE(n) && READ_BEFORE(n) &&
     RETURNED_BEFORE(n) ->
#endif
      freed[PLACE(n)]++;
      returned = returned | BIT(n)
  fi;
  assert(!(seen & read & BIT(n)) || got[n] == n + 1);
  assert(size >= 0 || !(seen & subtracted & BIT(n)))
}

active proctype reader() {
  do
  :: returned == UP_TO(SAMPLES - 1) && read == returned && subtracted == returned -> break
  :: atomic { read_steps(0) }
  :: atomic { read_steps(1) }
  :: atomic { read_steps(2) }
  :: atomic { read_steps(3) }
  od
}
