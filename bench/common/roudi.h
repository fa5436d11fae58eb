// Runs iceoryx's own daemon, which Cyclone DDS needs, since sftd serves programs of SFT only. The daemon
// has its own /dev/shm and /tmp, so that it does not collide with sftd.
#pragma once

#include <sys/types.h>

namespace sft::bench {

class Roudi {
 public:
  /// Starts the daemon and waits until it serves programs. Ends the program with a message if that fails.
  /// REQUIRES: the program is isolated.
  Roudi();
  ~Roudi();
  Roudi(const Roudi&) = delete;
  Roudi& operator=(const Roudi&) = delete;

  /// Moves the calling process to the daemon's namespace, where the daemon can be reached.
  void enter() const;

 private:
  pid_t process_;
  int mounts_ = -1;
};

}  // namespace sft::bench
