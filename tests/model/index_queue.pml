/* A queue between a writer and a reader: the places of IndexQueue as SFT replaces it, around the elements and
   the size of iceoryx's LockFreeQueue. Each memory access is a step of its own. A thread may take its steps in
   any order that C++ allows: steps before a release stay before it, steps behind an acquire stay behind it, and
   no others are ordered. Each element that is taken is the one that was pushed, and the size is never below
   zero. See model.md.

   PUBLISHED_RELAXED and SEEN_RELAXED: the filled places have the memory orders of iceoryx 2.0.x.
   GIVEN_BACK_RELAXED: the free places have them. */

#define SAMPLES 4 /* writer and reader have steps for each, below */
#define CAPACITY 2
#define BIT(n) (1 << (n))
#define UP_TO(n) (BIT((n) + 1) - 1) /* the bits of samples 0 to n */
#define PLACE(n) ((n) % CAPACITY)

/* Samples are numbered from 0 on. In memory the numbers are greater by 1, since 0 means none. */
byte element[CAPACITY];
byte used[CAPACITY];  /* the cells of the queue of filled places: the last sample in each */
byte freed[CAPACITY]; /* the cells of the queue of free places: how often each place was given back */
short size;

/* The steps that the writer has taken: bit n is for sample n. */
byte found, written, counted, published;

/* True if this step was taken for all samples up to n, or for publishing, up to the one before n. */
#define WRITTEN_BEFORE(n) ((written & UP_TO(n)) == UP_TO(n))
#define COUNTED_BEFORE(n) ((counted & UP_TO(n)) == UP_TO(n))
#define PUBLISHED_BEFORE(n) ((published & (UP_TO(n) >> 1)) == (UP_TO(n) >> 1))

inline write_steps(n) {
  if
  /* Pops a free place, with acquire: all later steps of the writer come after it. */
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
#define MAY_GO_ON(n) true /* the thread speculates that the place is filled, and is right */
#else
#define MAY_GO_ON(n) ((seen & BIT(n)) != 0)
#endif

inline read_steps(n) {
  if
  /* Sees the filled place. */
  :: !(seen & BIT(n)) && seen == BIT(n) - 1 && used[PLACE(n)] == n + 1 -> seen = seen | BIT(n)
  /* Subtracts from the size, with acquire. */
  :: !(subtracted & BIT(n)) && subtracted == BIT(n) - 1 && MAY_GO_ON(n) ->
      size--;
      subtracted = subtracted | BIT(n)
  :: !(read & BIT(n)) && (subtracted & BIT(n)) -> got[n] = element[PLACE(n)]; read = read | BIT(n)
  /* Gives the place back. This is a store, which is never speculative. */
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
