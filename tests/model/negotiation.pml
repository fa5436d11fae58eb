/* The STR handshake between a writer's node and a reader's node. model.md says which construct stands for
   which code, what is left out and why that is sound. Either node may end and come back under another id
   (0, then 1). Options -D set which events may happen and how often, and the mistakes that the checker has to find. */

#ifndef MASK_CHANGES
#define MASK_CHANGES 0
#endif
#ifndef READER_RESTARTS
#define READER_RESTARTS 0
#endif
#ifndef WRITER_RESTARTS
#define WRITER_RESTARTS 0
#endif
#ifndef LEASE_LOSSES
#define LEASE_LOSSES 0 /* how often the reader's lease expires in the writer's node */
#endif
#ifndef WRITER_LOSSES
#define WRITER_LOSSES 0 /* how often the reader's node loses the writer for so long that it discards it */
#endif
#ifndef MEMORY_LOSSES
#define MEMORY_LOSSES 0 /* bit 0: the reader's node loses shared memory, bit 1: the writer's node; 0: there is none */
#endif
#ifndef IN_FLIGHT
#define IN_FLIGHT 2
#endif

#define NOWHERE 0
#define UDP 1
#define SHM 2
#define FULL 3

#define UNKNOWN 0
#define KNOWN 1
#define LOST 2

/* A request in one number: sequence, mask (2 leaves), the writers that the reader listens to, the writers that it is
   attached to. An announcement is the request in force, and one bit: the node has shared memory. */
#define REQUEST (sequence | wanted << 4 | listening << 6 | attached << 8)
#define ANNOUNCEMENT (REQUEST | reader_memory << 10)
#define SEQUENCE(q) ((q) & 15)
#define MASK(q) ((q) >> 4 & 3)
#define LISTENS(q, w) ((q) >> (6 + (w)) & 1)
#define IS_ATTACHED(q, w) ((q) >> (8 + (w)) & 1)
#define MEMORY(q) ((q) >> 10 & 1)
#define WITH_MEMORY_OF(q, other) (((q) & 1023) | ((other) & 1024))
#define BIT(w) (1 << (w))
#define HAS(set, w) ((set) >> (w) & 1)

/* The reader's node. */
byte reader = 0; /* the id, a new one at each start */
bool reader_up = true;
bool reader_memory = (MEMORY_LOSSES != 0);
byte wanted = 1;
byte sequence = 1;
byte listening, attached; /* writers, in the request in force */
byte heard;               /* writers that the reader knows */
byte shares;              /* those of them that announced shared memory */
byte connected;           /* writers whose datagrams the reader takes */
byte subscribed, fed;     /* writers that it has subscribed to in shared memory, and that it gets samples of there */
byte accepted = 1 << 1;   /* masks that it accepts */

/* The writer's node. */
byte writer = 0;
bool writer_up = true;
bool writer_memory = (MEMORY_LOSSES != 0);
bool port; /* the writer has a port in shared memory */
byte state[2];
short table[2]; /* newest request and announcement of each reader */
short early[2];
bool stale; /* the table has changed since the routes were set */
byte path[2];
byte mask[2];

/* The control topics, each with keep-last 1 for each reader and writer. */
bool announced[2]; /* the latest announcement is under way */
short announcement[2];
bool withdrawn[2]; /* the withdrawal of the reader is under way, behind the announcement */
bool requested[2];
short request[2];
short overtaken[2]; /* an older request, or a repeated one, which may arrive at any time */
bool writer_announced;
bool cut[2]; /* the writer's node has lost the reader's node: no control sample arrives until it finds that again */

/* Datagrams: writer, reader that it is sent to, mask that it names, mask that it is encoded with, request in force. */
chan datagrams = [IN_FLIGHT] of { byte, byte, byte, byte, byte };

/* Only the properties use these. */
bool gone[2];     /* the writer's node knows that the reader has left, or has discarded it */
byte asked[2];    /* masks that the reader asked for */
byte let_go;      /* writers that the reader does not listen to any more */
#ifdef LIVENESS
bool fresh;  /* the latest sample arrived, with the wanted mask */
bool missed; /* the previous sample was lost on the way */
#define note_arrival(is_wanted) fresh = fresh || (is_wanted); missed = false
#else
#define note_arrival(is_wanted) skip
#endif
#ifdef MASKS_NAMED_BY_REQUESTS
byte mask_at[16]; /* the mask of each request, by its sequence */
#define note_request() mask_at[sequence] = wanted
#else
#define note_request() skip
#endif

inline ask() {
  accepted = accepted | BIT(wanted);
  asked[reader] = asked[reader] | BIT(wanted);
  note_request()
}

inline announce() {
  announcement[reader] = ANNOUNCEMENT;
  announced[reader] = true
}

/* With keep-last 1 the previous request is overwritten, or is still under way and may be overtaken. */
inline send_request() {
  assert(sequence < 15);
  if
  :: requested[reader] && overtaken[reader] == 0 -> overtaken[reader] = request[reader]
  :: true
  fi;
  request[reader] = REQUEST;
  requested[reader] = true
}

inline start_reader() {
  reader_up = true;
  sequence = 1;
  listening = 0;
  attached = 0;
  heard = 0;
  shares = 0;
  connected = 0;
  subscribed = 0;
  fed = 0;
  accepted = 0;
  let_go = 0;
  ask();
  announce();
  writer_announced = writer_up
}

/* The later one of two records of a request is in force (Directory, Peer). */
inline adopt(r, q) {
#ifdef OLDER_REQUESTS_ACCEPTED
  table[r] = WITH_MEMORY_OF(q, table[r]);
  stale = true
#else
  if
  :: SEQUENCE(q) > SEQUENCE(table[r]) -> table[r] = WITH_MEMORY_OF(q, table[r]); stale = true
  :: else
  fi
#endif
}

/* An announcement arrives: Directory::show and Negotiation::endpoint_seen. */
inline seen(r, a) {
#ifdef ANNOUNCEMENTS_TAKE_BACK
  table[r] = a;
#else
  if
  :: SEQUENCE(table[r]) > SEQUENCE(a) -> table[r] = WITH_MEMORY_OF(table[r], a)
  :: else -> table[r] = a
  fi;
#endif
#ifdef RETURNS_NOT_NOTICED
  state[r] = (state[r] == LOST -> LOST : KNOWN);
#else
  state[r] = KNOWN;
#endif
  gone[r] = false;
  stale = true;
  if
  :: early[r] != 0 -> adopt(r, early[r]); early[r] = 0
  :: else
  fi
}

#ifdef REQUESTS_OF_THE_LOST_ADOPTED
#define IS_THERE(r) (state[r] != UNKNOWN)
#else
#define IS_THERE(r) (state[r] == KNOWN)
#endif

/* A request arrives: Negotiation::request_received. Directory keeps it if its endpoint is not known yet. */
inline received(r, q) {
  if
  :: IS_THERE(r) -> adopt(r, q)
#ifndef EARLY_REQUESTS_DROPPED
  :: !IS_THERE(r) && SEQUENCE(q) > SEQUENCE(early[r]) -> early[r] = q
#endif
  :: else
  fi
}

inline erase(r) {
#ifndef MASKS_OUTLIVE_READERS
  table[r] = 0;
  state[r] = UNKNOWN;
#endif
  gone[r] = true;
  stale = true
}

/* Negotiation::serving(), and LocalWriter::reconcile, which opens the port. */
#define IS_SERVED(r) (state[r] == KNOWN)
#ifdef LOST_READERS_SERVED
#undef IS_SERVED
#define IS_SERVED(r) (state[r] != UNKNOWN)
#endif
#define SHARED(r) (IS_SERVED(r) && writer_memory && MEMORY(table[r]))
#ifdef SERVED_UNASKED
#define BY_UDP(r) IS_SERVED(r)
#else
#define BY_UDP(r) (IS_SERVED(r) && LISTENS(table[r], writer))
#endif
#ifdef MEMORY_UNASKED
#define BY_SHM(r) SHARED(r)
#else
#define BY_SHM(r) (SHARED(r) && IS_ATTACHED(table[r], writer))
#endif
inline set_route(r) {
  path[r] = (BY_SHM(r) -> SHM : (BY_UDP(r) -> UDP : NOWHERE));
  mask[r] = (path[r] == NOWHERE -> 0 : MASK(table[r]))
}

active proctype writer_agent() {
  do
  :: d_step {
      writer_up && stale ->
      port = port || SHARED(0) || SHARED(1);
      set_route(0);
#if READER_RESTARTS
      set_route(1);
#endif
      stale = false
    }
  od
}

/* What LocalReader::reconcile connects, and what LocalReader::look_after_connections reports to writers. */
#define SHARING (reader_memory -> heard & shares : 0)
#define LISTENING (heard & connected)
#define ATTACHED (SHARING & fed)

active proctype reader_agent() {
  d_step {
    ask();
    announce();
    writer_announced = true
  };
  do
  :: d_step {
      reader_up && (heard & ~connected) != 0 -> connected = connected | heard;
      let_go = let_go & ~heard
    }
#if MEMORY_LOSSES
  :: d_step { reader_up && subscribed != SHARING -> subscribed = SHARING; fed = fed & subscribed }
#endif
#if WRITER_RESTARTS || WRITER_LOSSES
  :: atomic {
      reader_up && ((listening | attached) & ~heard) != 0 -> /* the reader has discarded a writer */
      listening = listening & heard;
      attached = attached & heard;
      sequence++;
      note_request();
#ifndef END_NOT_TOLD
      send_request()
#endif
    }
#endif
  :: atomic {
      reader_up && ((listening | attached) & ~heard) == 0 && (listening != LISTENING || attached != ATTACHED) ->
      listening = LISTENING;
      attached = ATTACHED;
      sequence++;
      note_request();
      send_request()
    }
  /* Some time later: LocalReader::forget_what_was_in_flight */
  :: d_step { reader_up && (accepted & ~BIT(wanted)) != 0 -> accepted = BIT(wanted) }
  :: d_step { reader_up && (connected & ~heard) != 0 -> let_go = let_go | (connected & ~heard); connected = connected & heard }
  od
}

#if MEMORY_LOSSES
/* The daemon connects a subscriber with the writer's port when both exist. */
active proctype daemon() {
  do
  :: d_step { port && HAS(subscribed, writer) && !HAS(fed, writer) -> fed = fed | BIT(writer) }
  od
}
#endif

#define ARRIVES(what, r) (what[r] && !cut[r])

/* Announcements and withdrawals arrive in order, requests at any time. Old requests may arrive again. */
active proctype control() {
  byte r;
  do
  :: atomic {
      writer_up && (ARRIVES(announced, 0) || ARRIVES(announced, 1)) ->
      r = (ARRIVES(announced, 0) -> 0 : 1);
      seen(r, announcement[r]);
      announced[r] = false
    }
#if READER_RESTARTS
  :: d_step { writer_up && withdrawn[0] && !cut[0] -> announced[0] = false; erase(0); early[0] = 0; withdrawn[0] = false }
#endif
  od
}

active proctype request_topic() {
  byte r;
  do
  :: atomic {
      writer_up && (ARRIVES(requested, 0) || ARRIVES(requested, 1)) ->
      r = (ARRIVES(requested, 0) -> 0 : 1);
      received(r, request[r]);
      requested[r] = false;
      if /* the request may arrive a second time */
      :: overtaken[r] == 0 -> overtaken[r] = request[r]
      :: true
      fi
    }
  :: atomic {
      writer_up && (ARRIVES(overtaken, 0) || ARRIVES(overtaken, 1)) ->
      r = (ARRIVES(overtaken, 0) -> 0 : 1);
      received(r, overtaken[r]);
      overtaken[r] = 0
    }
  od
}

active proctype writer_topic() {
  do
  :: d_step {
      reader_up && writer_up && writer_announced ->
      heard = heard | BIT(writer);
      shares = (shares & ~BIT(writer)) | (writer_memory << writer);
      writer_announced = false
    }
#if WRITER_RESTARTS
  :: d_step { reader_up && (heard & ~BIT(writer)) != 0 -> heard = heard & BIT(writer) }
#endif
  od
}

#if READER_RESTARTS || LEASE_LOSSES
inline lose(r) {
  cut[r] = true;
  announced[r] = false;
  requested[r] = false;
  overtaken[r] = 0
}

/* The writer's node receives nothing more from the reader's node, which has crashed, or seems to have crashed. */
active proctype leases() {
  byte losses = LEASE_LOSSES;
  do
#if READER_RESTARTS
  :: d_step {
      writer_up && state[0] == KNOWN && (reader != 0 || !reader_up) && !withdrawn[0] ->
      state[0] = LOST;
      lose(0);
      stale = true
    }
  :: d_step { writer_up && state[0] == LOST && (reader != 0 || !reader_up) -> erase(0) }
#endif
#if LEASE_LOSSES
  :: d_step {
      writer_up && reader_up && state[reader] == KNOWN && losses > 0 ->
      losses--;
      state[reader] = LOST;
      lose(reader);
      stale = true
    }
  :: d_step { writer_up && reader_up && state[reader] == LOST -> erase(reader) } /* a minute later */
  :: d_step { /* the reader's node is found again, and its records arrive, since the topics are transient-local */
      writer_up && reader_up && cut[reader] ->
      cut[reader] = false;
      announced[reader] = true;
      requested[reader] = (request[reader] != 0)
    }
#endif
  od
}
#endif

#if WRITER_LOSSES
active proctype other_leases() {
  d_step { reader_up && HAS(heard, writer) -> heard = heard & ~BIT(writer) };
  d_step { writer_announced = true }
}
#endif

#if MASK_CHANGES
active proctype recorder() {
  byte changes = MASK_CHANGES;
  do
  :: atomic {
      reader_up && changes > 0 && sequence < 12 ->
      changes--;
      if
      :: wanted != 1 -> wanted = 1
      :: wanted != 2 -> wanted = 2
      fi;
      sequence++;
      ask();
      send_request()
    }
  :: changes > 0 -> break
  :: changes == 0 -> break
  od
}
#endif

#if READER_RESTARTS
active proctype reader_process() {
  atomic {
    reader_up = false;
    if
    :: withdrawn[0] = true /* an orderly end; else the process is killed */
    :: true
    fi
  };
  atomic {
    reader = 1;
    if
    :: wanted = 1
    :: wanted = 2
    fi;
    start_reader()
  }
}
#endif

#if WRITER_RESTARTS
active proctype writer_process() {
  d_step {
    writer_up = false;
    port = false;
    fed = fed & ~BIT(0);
    path[0] = NOWHERE; path[1] = NOWHERE;
    table[0] = 0; table[1] = 0;
    early[0] = 0; early[1] = 0;
    state[0] = UNKNOWN; state[1] = UNKNOWN;
    gone[0] = false; gone[1] = false;
    cut[0] = false; cut[1] = false;
    withdrawn[0] = false;
    overtaken[0] = 0; overtaken[1] = 0;
    announced[0] = false; announced[1] = false;
    requested[0] = false; requested[1] = false
  };
  d_step {
    writer = 1;
    writer_up = true;
    writer_announced = true;
    announced[reader] = reader_up;
    requested[reader] = (reader_up && request[reader] != 0)
  }
}
#endif

#if MEMORY_LOSSES & 1
/* Shared memory is lost, and found again: Negotiation::self_changed, Reconciler::look_after_memory. */
active proctype memory_of_reader() {
  atomic {
    reader_up && reader_memory ->
    reader_memory = false;
    subscribed = 0;
    fed = 0;
    if
    :: attached != 0 -> attached = 0; sequence++; note_request()
    :: else
    fi;
    announce();
    send_request()
  };
  atomic { reader_up && !reader_memory -> reader_memory = true; announce(); send_request() }
}
#endif

#if MEMORY_LOSSES & 2
active proctype memory_of_writer() {
  d_step {
    writer_up && writer_memory ->
    writer_memory = false;
    port = false;
    fed = fed & ~BIT(writer);
    stale = true;
    writer_announced = true
  };
  d_step { writer_up && !writer_memory -> writer_memory = true; stale = true; writer_announced = true }
}
#endif

/* No control sample is under way, and neither agent has work. */
#define AT_REST (!stale && !announced[0] && !announced[1] && !requested[0] && !requested[1] && \
                 overtaken[0] == 0 && overtaken[1] == 0 && !withdrawn[0] && !writer_announced && \
                 connected == heard && listening == LISTENING && attached == ATTACHED && \
                 subscribed == SHARING && fed == (port -> subscribed & BIT(writer) : 0) && \
                 !cut[reader])

/* The final state: if the reader knows this writer, it is served what it wants, by the best path. */
#define AGREED (path[reader] == ((HAS(heard, writer) && reader_memory && writer_memory) -> SHM : \
                                 (HAS(heard, writer) -> UDP : NOWHERE)) && \
                (path[reader] == NOWHERE || mask[reader] == wanted))

inline check_route(r) {
  if
  :: path[r] != NOWHERE && !stale ->
      assert(state[r] == KNOWN);         /* no sample before the first request, or while its node is lost */
      assert(!gone[r]);                  /* no mask outlives its reader */
      assert(HAS(asked[r], mask[r]));    /* the mask is not another reader's */
      assert(path[r] == UDP -> LISTENS(table[r], writer) : IS_ATTACHED(table[r], writer))
  :: else
  fi
}

inline publish(r) {
  if
  :: path[r] == UDP ->
      if
      :: nfull(datagrams) -> datagrams!writer, r, mask[r], mask[r], SEQUENCE(table[r])
      :: full(datagrams)
      fi
#if MEMORY_LOSSES
  :: path[r] == SHM -> note_arrival(r == reader && reader_up && HAS(fed, writer))
#endif
  :: else
  fi
}

active proctype publisher() {
  do
  :: atomic {
      writer_up ->
#ifdef LIVENESS
      fresh = false;
#endif
      check_route(0);
      if
      :: AT_REST && reader_up -> assert(AGREED)
      :: else
      fi;
      publish(0);
#if READER_RESTARTS
      check_route(1);
      publish(1)
#endif
    }
  od
}

/* Any sample may be lost, but not all: with LIVENESS, never two wanted samples in a row. A datagram to a former reader
   may arrive at the socket of the present one, which then has the same address. */
active proctype network() {
  byte w, r, named, encoded, at;
  do
  :: atomic {
      datagrams?w, r, named, encoded, at ->
#if IN_FLIGHT > 1
      if /* the next datagram may overtake this one */
      :: true
      :: nempty(datagrams) -> datagrams!w, r, named, encoded, at; datagrams?w, r, named, encoded, at
      fi;
#endif
      if
      :: reader_up ->
          assert(r != reader || HAS(connected, w) || HAS(let_go, w)); /* the reader knows the writer */
#ifdef MASKS_NAMED_BY_REQUESTS
          named = mask_at[at];
#endif
          if
          :: HAS(connected, w) && HAS(accepted, named) ->
              assert(named == encoded); /* P1 */
              note_arrival(r == reader && named == wanted && w == writer)
          :: else
          fi
#ifdef LIVENESS
      :: !missed -> missed = true
      :: !reader_up
#else
      :: true
#endif
      fi;
      w = 0; r = 0; named = 0; encoded = 0; at = 0
    }
  od
}

#ifdef LIVENESS
/* P2: a requirement that does not change any more is served again and again. */
ltl served { []<> (fresh || !reader_up || !writer_up) }
#endif
