// A part of a session, which is told when the session is lost.
#pragma once

#include <cstdint>

namespace sft::shm {

/// The state of a port. It must not use iceoryx any more after the session is lost.
class SessionMember {
 public:
  enum class Loss : std::uint8_t {
    now,    ///< iceoryx may be used until lose() returns
    before  ///< the session was lost before it had this member: iceoryx must not be used
  };
  /// Returns when no other thread is using iceoryx through this member any more.
  virtual void lose(Loss loss) noexcept = 0;
  /// Returns whether other members of this process may get samples from this one. It is told of the loss
  /// before them, so that they know by then what has arrived.
  virtual bool sends() const noexcept = 0;

 protected:
  ~SessionMember() = default;
};

}  // namespace sft::shm
