/* Dispatch::serve on the agent's thread beside publish() and commit() on the program's thread. In each
   interleaving, no route asks for a field that the present sample is not encoded with, or depends on a gate
   that was not asked about the sample. See model.md. */

#ifndef CHANGES
#define CHANGES 3
#endif
#define FULL 3
#define COVERS(wide, narrow) (((narrow) & ~(wide)) == 0)

/* Gates are named 1 and 2, and 0 stands for none. A set of gates has a bit for each. */
#define GATE(g) ((1 << (g)) >> 1)

/* Outlets: the mask to encode, the gates to ask, and the ports to send to. A change stores all of them at once. */
byte outlets_mask;
bool outlets_to_shm, outlets_to_udp;
#ifdef GATES
byte outlets_gates;
byte shm_gate, udp_gate; /* the gates of the routes of the two ports */
#endif
bool publishing;

/* The routes of the port for UDP, as the union of their masks. What holds for the union, holds for each mask.
   The port for shared memory needs no mask, since a sample is complete there. */
byte udp_routes;

active proctype agent() {
  byte changes = CHANGES, udp;
  bool shm;
#ifdef GATES
  byte for_shm, for_udp, gates;
#endif
  do
  :: changes > 0 ->
      changes--;
      /* Negotiation::serving() returns other routes. */
      d_step { udp = 0; shm = false };
      if
      :: udp = 0
      :: udp = 1
      :: udp = 2
      :: udp = 3
      fi;
      if
      :: shm = true
      :: shm = false
      fi;
#ifdef GATES
      if
      :: shm -> for_shm = 0
      :: shm -> for_shm = 1
      :: shm -> for_shm = 2
      :: !shm -> for_shm = 0
      fi;
      if
      :: udp != 0 -> for_udp = 0
      :: udp != 0 -> for_udp = 1
      :: udp != 0 -> for_udp = 2
      :: udp == 0 -> for_udp = 0
      fi;
      gates = GATE(for_shm) | GATE(for_udp);
#endif
#ifndef WITHOUT_UNION
      if
#ifdef GATES
#ifdef GATES_WITHOUT_UNION
      :: !COVERS(outlets_mask, (shm -> FULL : udp)) ->
#else
      :: !COVERS(outlets_mask, (shm -> FULL : udp)) || !COVERS(outlets_gates, gates) ->
#endif
          d_step {
            outlets_mask = outlets_mask | (shm -> FULL : udp);
            outlets_gates = outlets_gates | gates
          };
#else
      :: !COVERS(outlets_mask, (shm -> FULL : udp)) ->
          outlets_mask = outlets_mask | (shm -> FULL : udp);
#endif
#ifndef WITHOUT_WAITING
          !publishing
#endif
      :: else
      fi;
#endif
#ifdef GATES
      shm_gate = for_shm;
      d_step { udp_routes = udp; udp_gate = for_udp };
      d_step {
        outlets_mask = (shm -> FULL : udp); outlets_to_shm = shm; outlets_to_udp = (udp != 0);
        outlets_gates = gates; gates = 0; for_shm = 0; for_udp = 0
      }
#else
      udp_routes = udp;
      d_step { outlets_mask = (shm -> FULL : udp); outlets_to_shm = shm; outlets_to_udp = (udp != 0) }
#endif
  :: changes == 0 -> break
  od
}

/* Uses the routes: UdpWriter::send, and in shared memory the list of queues. */
inline send() {
  if
  :: to_shm ->
      assert(encoded == FULL);
#ifdef GATES
      gate = shm_gate;
      assert(gate == 0 || COVERS(asked, GATE(gate)))
#endif
  :: else
  fi;
  if
  :: to_udp ->
#ifdef GATES
      d_step { routes = udp_routes; gate = udp_gate };
      assert(COVERS(encoded, routes));
      assert(gate == 0 || COVERS(asked, GATE(gate)))
#else
      routes = udp_routes;
      assert(COVERS(encoded, routes))
#endif
  :: else
  fi
}

active proctype program() {
  byte encoded, routes;
  bool to_shm, to_udp;
#ifdef GATES
  byte asked, gate; /* the gates that were asked about the present sample; the gate of a route */
#endif
  do
  :: true -> /* publish() */
#ifndef ANNOUNCED_LATE
      publishing = true;
#endif
      d_step {
        encoded = outlets_mask; to_shm = outlets_to_shm; to_udp = outlets_to_udp;
#ifdef GATES
        asked = outlets_gates
#endif
      };
#ifdef ANNOUNCED_LATE
      publishing = true;
#endif
      send();
      d_step {
        publishing = false; encoded = 0; routes = 0; to_shm = false; to_udp = false;
#ifdef GATES
        asked = 0; gate = 0
#endif
      }
#ifdef GATES
  :: true -> /* commit() of a loan, which has all fields. It begins a Call only for the gates. */
      publishing = true;
      d_step { encoded = FULL; to_shm = outlets_to_shm; to_udp = outlets_to_udp; asked = outlets_gates };
      send();
      d_step {
        publishing = false; encoded = 0; routes = 0; to_shm = false; to_udp = false; asked = 0; gate = 0
      }
#else
  :: true -> /* commit() of a loan, which has all fields, so that it does not set `publishing` */
      d_step { to_shm = outlets_to_shm; to_udp = outlets_to_udp };
      if
      :: to_udp -> routes = udp_routes; assert(COVERS(FULL, routes))
      :: else
      fi;
      d_step { routes = 0; to_shm = false; to_udp = false }
#endif
  od
}
