/* Dispatch::serve, on the agent's thread, against publish() and commit() on the program's: whatever the
   interleaving, no route asks for a field that the sample at hand is not encoded with. See model.md. */

#ifndef CHANGES
#define CHANGES 3
#endif
#define FULL 3
#define COVERS(wide, narrow) (((narrow) & ~(wide)) == 0)

/* Outlets: what has to be encoded, and which ports are sent to. A change stores all of it at once. */
byte outlets_mask;
bool outlets_to_shm, outlets_to_udp;
bool publishing;

/* The routes of the port for UDP: the union of their masks (what holds for that, holds for each). The other
   port needs none: all of a sample is there. */
byte udp_routes;

active proctype agent() {
  byte changes = CHANGES, udp;
  bool shm;
  do
  :: changes > 0 ->
      changes--;
      /* Negotiation::serving wants something else. */
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
#ifndef WITHOUT_UNION
      if
      :: !COVERS(outlets_mask, (shm -> FULL : udp)) ->
          outlets_mask = outlets_mask | (shm -> FULL : udp);
#ifndef WITHOUT_WAITING
          !publishing
#endif
      :: else
      fi;
#endif
      udp_routes = udp;
      d_step { outlets_mask = (shm -> FULL : udp); outlets_to_shm = shm; outlets_to_udp = (udp != 0) }
  :: changes == 0 -> break
  od
}

active proctype program() {
  byte encoded, routes;
  bool to_shm, to_udp;
  do
  :: true -> /* publish() */
#ifndef ANNOUNCED_LATE
      publishing = true;
#endif
      d_step { encoded = outlets_mask; to_shm = outlets_to_shm; to_udp = outlets_to_udp };
#ifdef ANNOUNCED_LATE
      publishing = true;
#endif
      if
      :: to_shm -> assert(encoded == FULL)
      :: else
      fi;
      if
      :: to_udp ->
          routes = udp_routes; /* UdpWriter::follow_routes */
          assert(COVERS(encoded, routes))
      :: else
      fi;
      d_step { publishing = false; encoded = 0; routes = 0; to_shm = false; to_udp = false }
  :: true -> /* commit() of a loan, which has all fields: announces nothing */
      d_step { to_shm = outlets_to_shm; to_udp = outlets_to_udp };
      if
      :: to_udp -> routes = udp_routes; assert(COVERS(FULL, routes))
      :: else
      fi;
      d_step { routes = 0; to_shm = false; to_udp = false }
  od
}
