/* The list of the free chunks of a pool: LoFFLi::pop() and push() as SFT replaces them, and with
   OWN_COUNT_GOES_ON as iceoryx 2.0.x has them. Each chunk has at most one owner, and no chunk is lost. See
   model.md. */

#ifndef OPERATIONS
#define OPERATIONS 6 /* operations of the process that runs freely; the other two have one each */
#endif
#define CHUNKS 4
#define TAKEN (CHUNKS + 1)

byte next[CHUNKS];
byte head = 0, count = 1; /* one atomic operation exchanges both */

/* Only the properties use these. */
byte owner[CHUNKS]; /* the process that owns each chunk, plus 1; 0: none */
byte running = 3;

inline exchange(to) {
#ifdef OWN_COUNT_GOES_ON
  mine++;
#else
  mine = seen_count + 1;
#endif
  if
  :: head == seen && count == seen_count -> head = to; count = mine; done = true
  :: else -> seen = head; seen_count = count
  fi
}

inline load_head() {
  d_step { seen = head; seen_count = count; mine = count; done = false }
}

inline pop() {
  load_head();
  do
  :: done || seen >= CHUNKS -> break
  :: else ->
      following = next[seen];
      atomic {
        chunk = seen;
        exchange(following);
        if
        :: done -> assert(owner[chunk] == 0); owner[chunk] = _pid + 1
        :: else
        fi
      }
  od;
  if
  :: done -> next[chunk] = TAKEN
  :: else /* the list is empty */
  fi
}

inline push() {
  assert(next[chunk] == TAKEN);
  load_head();
  do
  :: done -> break
  :: else ->
      next[chunk] = seen;
      atomic {
        exchange(chunk);
        if
        :: done -> owner[chunk] = 0
        :: else
        fi
      }
  od
}

inline choose_own() {
  chunk = 0;
  do
  :: chunk < CHUNKS && owner[chunk] == _pid + 1 -> break
  :: chunk < CHUNKS -> chunk++
  :: chunk == CHUNKS -> break
  od
}

proctype process(byte operations) {
  byte seen, seen_count, mine, following, chunk;
  bool done;
  do
  :: operations == 0 -> break
  :: operations > 0 ->
      operations--;
      if
      :: pop()
      :: d_step { choose_own() }
         if
         :: chunk < CHUNKS -> push()
         :: else
         fi
      fi
  od;
  running--
}

inline count_free() {
  free = 0;
  at = head;
  do
  :: at < CHUNKS -> free++; at = next[at]
  :: else -> break
  od
}

init {
  byte at, free;
  atomic {
    do
    :: at < CHUNKS -> next[at] = at + 1; at++
    :: else -> break
    od;
    run process(1);
    run process(1);
    run process(OPERATIONS)
  }
  running == 0;
  d_step {
    count_free();
    at = 0;
    do
    :: at < CHUNKS -> free = free + (owner[at] != 0 -> 1 : 0); at++
    :: else -> break
    od
  }
  assert(free == CHUNKS) /* no chunk is lost */
}
