// A part of a session, which is notified when the session is lost.
#pragma once

#include <cstdint>

namespace sft::shm {

/// The state of a port, which must not use iceoryx any more after the session is lost.
class SessionMember {
 public:
  enum class Loss : std::uint8_t {
    now,    ///< iceoryx may be used until lose() returns
    before  ///< the session was lost before the member joined it: iceoryx must not be used
  };
  /// Handles the loss. Returns when no other thread is using iceoryx through this member any more.
  virtual void lose(Loss loss) noexcept = 0;
  /// Returns whether other members of this process may get samples from this member. If a session is lost,
  /// lose() of such members is called first, so that the other members then know which samples have
  /// arrived.
  virtual bool sends() const noexcept = 0;

 protected:
  ~SessionMember() = default;
};

}  // namespace sft::shm
