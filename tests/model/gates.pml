/* Gate and SequenceAccount: what a reader that changes its conditions makes of the numbers that samples carry.
   What was withheld never counts as lost, and what has passed and did not come always does. See model.md. */

#ifndef SAMPLES
#define SAMPLES 4
#endif
#ifndef CHANGES
#define CHANGES 2
#endif
#define BIT(n) (1 << (n))
#define HAS(set, n) ((set) >> (n) & 1)

/* A sample on its way. A network carries its sequence, its gate and its number in that gate. Shared memory carries its
   sequence and its numbers in gates 1 and 2. */
chan way = [2] of { byte, byte, byte };

/* The gates for two sets of conditions are 1 and 2; 0 stands for no conditions. */
byte numbers[3];
bool next_passes[3];

byte wish;    /* what the reader asks for */
byte serving; /* what the writer knows of that */
bool done;

byte last, last_gate, last_number; /* SequenceAccount */
bool has_conditions, had_conditions;
byte gates; /* WriterAccounts::gates, as a set */

/* Only the properties read these: what was in force for each sample, which samples were for the reader, and which have
   passed each gate; whether the reader has asked for conditions, or for anything, since it took a sample. */
byte served[SAMPLES + 1];
short sent;
short passed[3];
bool asked_conditions, asked;

/* Gate::consider. Other readers may have the same conditions, and may have asked for them just now. */
inline consider(gate) {
  passes = false;
  if
  :: serving == gate && next_passes[gate] -> next_passes[gate] = false; passes = true
  :: serving == gate && !next_passes[gate] -> passes = true
  :: serving == gate && !next_passes[gate] -> skip /* withheld */
  :: serving != gate -> passes = true
  :: serving != gate -> skip /* withheld, or nobody is behind the gate */
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
  byte sequence = 1;
  bool passes, is_sent;
  do
  :: atomic { serving != wish -> /* Dispatch::serve, Gates::open_for */
      serving = wish;
      if
      :: serving != 0 ->
          next_passes[serving] = true;
#ifdef NUMBERS_BEGIN_ANEW
          numbers[serving] = 0
#endif
      :: else
      fi
    }
  :: sequence <= SAMPLES ->
      atomic { /* Dispatch::admit */
        consider(1);
        consider(2);
        served[sequence] = serving;
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
          way!sequence, served[sequence], (served[sequence] == 0 -> 0 : numbers[served[sequence]])
#endif
      :: else
      fi;
      sequence++
  :: sequence > SAMPLES -> break
  od;
  done = true
}

#ifndef MEMORY
/* The network may lose a sample, deliver it later than one that was sent behind it, or deliver it twice. */
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

/* SequenceAccount::lost_before */
inline count_lost() {
  same_gate = (gate != 0 && gate == last_gate && number != 0 && last_number != 0);
  if
#ifdef NUMBERS_NOT_LOOKED_AT
  :: true -> lost = gap
#else
  :: same_gate -> lost = number - last_number - 1
  :: !same_gate && (gate != 0 || last_gate != 0 || had_conditions) -> lost = 0
  :: !same_gate && gate == 0 && last_gate == 0 && !had_conditions -> lost = gap
#endif
  fi;
  if
  :: lost > gap -> lost = gap /* never; std::min in the code */
  :: else
  fi
}

/* Nothing in the gap was taken. A gap is even if the writer knew of one wish all the time. */
inline check() {
  is_even = (served[sequence] == served[last]);
  at = last + 1;
  do
  :: at < sequence ->
      missing = missing + HAS(sent, at);
      through_gate = through_gate + HAS(passed[gate], at);
      is_even = is_even && served[at] == served[last];
      at++
  :: else -> break
  od;
  assert(!is_even || lost <= missing);
  assert(!is_even || asked || served[sequence] != wish || lost == missing);
  assert(!same_gate || lost == through_gate);
  assert(is_even || same_gate || lost == 0 || (gate == 0 && last_gate == 0 && !asked_conditions))
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
      had_conditions = has_conditions;
      asked_conditions = has_conditions;
      asked = (gates != BIT(wish)) /* the sample may have been found to be of a former gate */
  :: else
  fi
}

/* Intake::put, of the gates that the reader has asked for. */
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
  byte changes = CHANGES, sequence, a, b, gate, number, gap, lost, at, missing, through_gate;
  bool same_gate, is_even;
  gates = BIT(0);
  do
  :: d_step { nempty(way) -> way?sequence, a, b; find_gate(); enter();
      sequence = 0; a = 0; b = 0; gate = 0; number = 0; gap = 0; lost = 0; at = 0; missing = 0;
      through_gate = 0; same_gate = false; is_even = false
    }
#ifdef MEMORY
  :: atomic { nempty(way) -> way?sequence, a, b; sequence = 0; a = 0; b = 0 } /* pushed out of the queue */
#endif
  :: atomic { changes > 0 -> /* ask_conditions, and the request is under way */
      changes--;
      if
      :: wish != 0 -> wish = 0
      :: wish != 1 -> wish = 1
      :: wish != 2 -> wish = 2
      fi;
      asked = true;
      has_conditions = (wish != 0);
      asked_conditions = asked_conditions || has_conditions;
#ifdef FORMER_CONDITIONS_FORGOTTEN
      had_conditions = has_conditions;
#else
      had_conditions = had_conditions || has_conditions;
#endif
#ifdef MEMORY
      gates = gates | BIT(wish)
#else
      gates = BIT(wish) /* not looked at */
#endif
    }
#ifdef MEMORY
  :: atomic { empty(way) && serving == wish && gates != BIT(wish) -> gates = BIT(wish) } /* forget_former_conditions */
#endif
  :: done && empty(way) -> break
  od
}
