/* Intake: how a reader takes one writer's samples while they change from one path to the other, or arrive by
   both. Every sample is taken once or counted as lost once, but never both. Samples before the first one that
   was taken are neither. See model.md. */

#ifndef SAMPLES
#define SAMPLES 5
#endif
#define BIT(n) (1 << (n))
#define HAS(set, n) ((set) >> (n) & 1)

chan udp = [2] of { byte };
chan shm = [2] of { byte };

bool done;
byte last; /* the last sequence in SequenceAccount */
byte lost; /* the losses that it counts */
byte received;

/* Only the properties use these: the first sample that was taken, all that were taken, and those counted as lost. */
byte first;
short taken, counted;

active proctype writer() {
  byte sequence = 1;
  do
  :: sequence <= SAMPLES ->
      if
      :: udp!sequence
      :: shm!sequence
      :: udp!sequence; shm!sequence /* for a moment both paths have a route to the reader */
      :: true                       /* there was no memory, or the path was just given up */
      fi;
      sequence++
  :: sequence > SAMPLES -> break
  od;
  done = true
}

/* A sample by UDP may be lost, arrive later than one that was sent after it, or arrive twice. */
active proctype network() {
  byte sequence;
  do
  :: atomic { udp?sequence -> sequence = 0 }
  :: atomic { len(udp) == 2 -> udp?sequence; udp!sequence; sequence = 0 }
  :: atomic { len(udp) == 1 -> udp?<sequence>; udp!sequence; sequence = 0 }
  :: done && empty(udp) -> break
  od
}

inline take(sequence) {
#ifdef DUPLICATES_TAKEN
  if
  :: sequence < last -> skip
#else
  if
  :: sequence <= last -> skip
#endif
  :: else ->
      assert(!HAS(taken, sequence));
      assert(!HAS(counted, sequence)); /* a sample that was counted as lost is never taken */
#ifdef GAPS_COUNTED_FROM_THE_BEGINNING
      if
      :: true ->
#else
      if
      :: last == 0 -> first = sequence
      :: else ->
#endif
          lost = lost + sequence - last - 1;
          do
          :: last + 1 < sequence -> last++; assert(!HAS(counted, last)); counted = counted | BIT(last)
          :: else -> break
          od
      fi;
      last = sequence;
      received++;
      taken = taken | BIT(sequence)
  fi
}

/* Intake::next: the reader looks at one sample of each port, and takes the lower sequence first. */
active proctype reader() {
  byte at_udp, at_shm;
  do
  :: atomic { at_udp == 0 && nempty(udp) -> udp?at_udp }
  :: atomic { at_shm == 0 && nempty(shm) -> shm?at_shm }
  :: atomic {
      (at_udp != 0 || at_shm != 0) && (at_udp != 0 || empty(udp)) && (at_shm != 0 || empty(shm)) ->
      if
      :: at_shm == 0 || (at_udp != 0 && at_udp <= at_shm) -> take(at_udp); at_udp = 0
      :: else -> take(at_shm); at_shm = 0
      fi
    }
  :: atomic { /* a port may be dropped with the samples in its queue: LocalReader::drop_memory */
      nempty(shm) -> shm?at_shm; at_shm = 0
    }
  :: done && empty(udp) && empty(shm) && at_udp == 0 && at_shm == 0 ->
      assert(last == 0 || received + lost == last - first + 1);
      break
  od
}
