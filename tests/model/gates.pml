/* Gate, AskedGates and SequenceAccount: how a reader that changes its conditions counts losses from the numbers in
   samples. A withheld sample never counts as lost. A sample that has passed the gate and did not arrive counts as lost
   if no other conditions can have been in force. See model.md. */

#ifndef SAMPLES
#define SAMPLES 4
#endif
#ifndef CHANGES
#define CHANGES 2
#endif
#define BIT(n) (1 << (n))
#define HAS(set, n) ((set) >> (n) & 1)

/* Samples under way. By the network, a sample has its sequence, its gate and its number in that gate. In shared memory
   it has its sequence and its numbers in gates 1 and 2. */
chan way = [2] of { byte, byte, byte };

/* Gates 1 and 2 are for two sets of conditions; 0 stands for no conditions. The numbers count what passed each gate. */
byte numbers[3];

byte wish;    /* the gate that the reader asks for */
byte serving; /* the gate by which the writer serves it */
bool done;

byte last, last_gate, last_number; /* SequenceAccount */
byte request;
byte asked[CHANGES + 1]; /* AskedGates */
byte latest, settled;
byte gates; /* AskedGates::nameable, as a set, with 0 if no conditions may be in force */

/* Only the properties read these: the samples that were sent to the reader; those that have passed each gate; and true
   if the last sample was taken when only the present wish could be in force. */
short sent;
short passed[3];
bool is_certain;

/* Gate::consider. Conditions may hold or not, also for the first sample. Other readers may have the same conditions. */
inline consider(gate) {
  passes = false;
  if
  :: passes = true
  :: skip /* the gate withholds the sample, or has no readers */
  fi;
  if
  :: passes -> numbers[gate]++; passed[gate] = passed[gate] | BIT(sequence)
  :: else ->
#ifdef NUMBERS_OF_WITHHELD
      numbers[gate]++
#else
      skip
#endif
  fi
}

active proctype writer() {
  byte sequence = 1, in_force;
  bool passes, is_sent;
  do
  :: atomic { serving != wish -> /* Dispatch::serve */
#ifdef NUMBERS_BEGIN_ANEW
      numbers[wish] = 0;
#endif
      serving = wish
    }
  :: sequence <= SAMPLES ->
      atomic { /* Dispatch::admit */
        consider(1);
        consider(2);
        in_force = serving;
        is_sent = (serving == 0 || HAS(passed[serving], sequence));
        if
        :: is_sent -> sent = sent | BIT(sequence)
        :: else
        fi
      }
      if
      :: is_sent ->
#ifdef MEMORY
          way!sequence, (HAS(passed[1], sequence) -> numbers[1] : 0),
              (HAS(passed[2], sequence) -> numbers[2] : 0)
#else
          way!sequence, in_force, (in_force == 0 -> 0 : numbers[in_force])
#endif
      :: else
      fi;
      sequence++
  :: sequence > SAMPLES -> break
  od;
  done = true
}

#ifndef MEMORY
/* The network may lose a sample, deliver it later than one that was sent after it, or deliver it twice. */
active proctype network() {
  byte sequence, a, b;
  do
  :: atomic { way?sequence, a, b -> sequence = 0 }
  :: atomic { len(way) == 2 -> way?sequence, a, b; way!sequence, a, b; sequence = 0 }
  :: atomic { len(way) == 1 -> way?<sequence, a, b>; way!sequence, a, b; sequence = 0 }
  :: done && empty(way) -> break
  od
}
#endif

/* AskedGates::only_gate_since(request) */
inline find_only_gate() {
  at = request;
  do
  :: at <= latest ->
      several = several || (only != 0 && asked[at] != 0 && asked[at] != only);
      only = (asked[at] != 0 -> asked[at] : only);
      at++
  :: else -> break
  od
#ifdef REQUESTS_BETWEEN_NOT_LOOKED_AT
  ;
  several = false;
  only = gate
#endif
}

/* SequenceAccount::lost_before */
inline count_lost() {
  find_only_gate();
  same_gate = (gate != 0 && gate == last_gate && number != 0 && last_number != 0 && !several && only == gate);
  if
#ifdef NUMBERS_NOT_LOOKED_AT
  :: true -> lost = gap
#else
  :: same_gate -> lost = number - last_number - 1
  :: !same_gate && (gate != 0 || last_gate != 0 || only != 0) -> lost = 0
  :: !same_gate && gate == 0 && last_gate == 0 && only == 0 -> lost = gap
#endif
  fi;
  if
  :: lost > gap -> lost = gap /* never; std::min in the code */
  :: else
  fi
}

/* Compares the counted losses with the samples in the gap, of which none was taken. */
inline check() {
  at = last + 1;
  do
  :: at < sequence ->
      missing = missing + HAS(sent, at);
      through_gate = through_gate + HAS(passed[gate], at);
      at++
  :: else -> break
  od;
  assert(lost <= missing);
#ifndef FORMER_CONDITIONS_FORGOTTEN /* this mistake also counts too few, but has to be found by counting too many */
  assert(!is_certain || request != latest || lost == missing);
#endif
  assert(!same_gate || lost == through_gate)
}

/* AskedGates::open_since */
inline find_open() {
  at = request;
  do
  :: at <= latest && asked[at] != 0 -> at++
  :: at <= latest && asked[at] == 0 -> request = at; break
  :: at > latest -> break
  od
}

inline enter() {
  if
  :: sequence > last && last == 0 -> skip
  :: sequence > last && last != 0 -> gap = sequence - last - 1; count_lost(); check()
  :: sequence <= last -> gate = 0; number = 0
  fi;
  if
  :: sequence > last ->
      last = sequence;
      last_gate = gate;
      last_number = number;
      request = (request > settled -> request : settled);
#ifdef MEMORY
      if
      :: gate == 0 -> find_open() /* RateKeeper::reader */
      :: else
      fi;
#endif
      is_certain = (request == latest && gates == BIT(wish)) /* otherwise, it may belong to a former gate */
  :: else
  fi
}

/* Intake::put: finds the gate of a sample among the gates that the reader has asked for. */
inline find_gate() {
#ifdef MEMORY
  if
  :: a != 0 && HAS(gates, 1) && b != 0 && HAS(gates, 2) -> gate = 1; number = 0
  :: a != 0 && HAS(gates, 1) && !(b != 0 && HAS(gates, 2)) -> gate = 1; number = a
  :: !(a != 0 && HAS(gates, 1)) && b != 0 && HAS(gates, 2) -> gate = 2; number = b
  :: else -> gate = 0; number = 0
  fi
#else
  gate = a;
  number = b
#endif
}

active proctype reader() {
  byte changes = CHANGES, sequence, a, b, gate, number, gap, lost, at, missing, through_gate, only;
  bool same_gate, several;
  gates = BIT(0);
  do
  :: d_step { nempty(way) -> way?sequence, a, b; find_gate(); enter();
      sequence = 0; a = 0; b = 0; gate = 0; number = 0; gap = 0; lost = 0; at = 0; missing = 0;
      through_gate = 0; only = 0; same_gate = false; several = false
    }
#ifdef MEMORY
  :: atomic { nempty(way) -> way?sequence, a, b; sequence = 0; a = 0; b = 0 } /* the queue drops the sample */
#endif
  :: atomic { changes > 0 -> /* ask_conditions; the request is under way from now on */
      changes--;
      if
      :: wish != 0 -> wish = 0
      :: wish != 1 -> wish = 1
      :: wish != 2 -> wish = 2
      fi;
#ifdef FORMER_CONDITIONS_FORGOTTEN
      latest = 0;
      request = 0;
      asked[0] = wish;
#else
      latest++;
      asked[latest] = wish;
#endif
#ifdef MEMORY
      gates = gates | BIT(wish)
#else
      gates = BIT(wish) /* only MEMORY needs a set of several gates */
#endif
    }
  :: atomic { empty(way) && serving == wish && settled < latest -> settled = latest; gates = BIT(wish) } /* settle */
  :: done && empty(way) -> break
  od
}
