// iceoryx's own daemon, which Cyclone DDS needs (sftd serves programs of SFT only), with a /dev/shm and a
// /tmp of its own, so that the two do not meet.
#pragma once

#include <sys/types.h>

namespace sft::bench {

class Roudi {
 public:
  /// Returns once it serves; ends the program with a message if that fails. REQUIRES: the program is
  /// isolated.
  Roudi();
  ~Roudi();
  Roudi(const Roudi&) = delete;
  Roudi& operator=(const Roudi&) = delete;

  /// Moves the calling process to where it is reached.
  void enter() const;

 private:
  pid_t process_;
  int mounts_ = -1;
};

}  // namespace sft::bench
