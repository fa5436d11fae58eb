// Decides which thread has the receiving role, which is the right to receive from the socket: the
// transport's own thread, or a thread that waits for a sample. Uses no clock, thread or I/O of its own. Any
// thread may call the functions.
//
// At most one waiting thread has the role, and keeps it while it sleeps on the socket. When this thread
// leaves with its sample, the role stays vacant for a short time. The thread will most likely come back
// soon, and then no thread had to be woken. Meanwhile the own thread stands by. It takes the role back if no
// thread came, if another thread waits, if a listener has to be called at once, or if the thread with the
// role does nothing although there is work. The last case occurs because a signal handler or a debugger can
// stop a thread.
//
// A turn is the time from begin() to end() in which a thread with the role receives. The role is neither a
// GuardedCall nor a Published value (core/sync), because it is passed on and never withdrawn for good. A
// thread that waits for the end of a turn only needs that another thread has the next turn.
//
// The class has no mutex. With a mutex, a thread that spins would sleep whenever the own thread held the
// mutex.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <type_traits>

namespace sft::udp {

class ReceivingRole {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The role stays vacant for this time, so that the last thread that had it can come back.
  static constexpr std::chrono::milliseconds vacancy{1};
  /// The pause between checks of a waiting thread with the role, by the own thread.
  static constexpr std::chrono::milliseconds look_period{50};
  /// The pause between checks of a thread with the role that seems to do nothing.
  static constexpr std::chrono::milliseconds second_look{2};
  /// If no waiting thread has used the role for this time, the transport's own thread takes the role and
  /// sleeps in the kernel. Then the next waiting thread has to wake it.
  static constexpr std::chrono::seconds own_again{1};

  // The result of enter(). A waiting thread calls enter(), then begin() and end() any number of times, then
  // leave().

  enum class Entry : std::uint8_t {
    taken,  ///< begin() may be called
    /// The own thread will pass the role to the caller, who may then call begin(). The caller has to wake
    /// the own thread.
    promised,
    occupied,  ///< another thread has the role; the caller calls wait_behind(), and sleeps until it is woken
    refused,   ///< the role is not given to waiting threads at present
  };
  Entry enter(Time now);
  /// Begins a turn: no other thread receives until end(). Returns false if the calling thread does not have
  /// the role.
  bool begin();
  void end(Time next_deadline);
  /// Returns true if the calling thread does not have the role and has not been promised the role.
  bool lost() const;

  struct Leaving {
    bool set_alarm = false;  ///< true if the own thread has to check the role at the end of the vacancy
    bool wake = false;       ///< true if the own thread has to check the role now
  };
  Leaving leave(Time now);

  /// Registers a thread that was denied the role and sleeps. Its caller must call unwait_behind()
  /// afterwards. Returns true if the caller has to wake the own thread.
  [[nodiscard]] bool wait_behind();
  void unwait_behind();

  /// Registers a reader whose listener must be called at once, and only by the own thread. While such a
  /// reader is registered, no other thread gets the role. Returns true if the caller has to wake both the
  /// thread that has the role and the own thread.
  [[nodiscard]] bool add_attended();
  void remove_attended();

  // The following functions are for the transport's own thread.

  enum class Duty : std::uint8_t {
    receive,   ///< a turn has begun; the own thread may sleep in it, because no other thread waits
    poll,      ///< the own thread waits, and calls take_turn() when a datagram has come
    stand_by,  ///< the own thread waits until the deadline
    stop,
  };
  struct Task {
    Duty duty = Duty::receive;
    Time until = Time::max();
    bool evicts = false;  ///< true if another thread has lost the role and has to be woken
  };
  /// Returns the next task of the own thread. `readable` is true if the socket has datagrams.
  Task next(Time now, bool readable);
  /// Begins a turn after the duty `poll`. Returns false if a waiting thread took the role meanwhile.
  bool take_turn();
  /// Ends the own thread's turn. Returns true if a waiting thread has the role now and has to be woken.
  [[nodiscard]] bool end_turn(Time next_deadline);
  /// Notes that the alarm of the own thread, which Leaving::set_alarm requested, has rung.
  void alarm_rang();

  /// Ends receiving, without waiting for any thread. Any thread may call this.
  void close();
  /// Returns true if a waiting thread is in a turn. That turn ends soon, even after close() or
  /// add_attended().
  bool waiter_in_turn() const;

 private:
  enum class Holder : std::uint8_t { own, waiter, nobody };
  /// Says if a waiting thread is between enter() and leave(). `awaited_waiter`: that thread has been
  /// promised the role.
  enum class Inside : std::uint8_t { nobody, other_thread, awaited_waiter };

  /// The complete state, which decides which thread may receive. It is one word, so that it changes
  /// atomically.
  struct State {
    std::uint16_t attended = 0;
    std::uint16_t behind = 0;
    Holder holder = Holder::own;
    Inside inside = Inside::nobody;
    bool in_turn = false;  ///< true if the thread with the role is in a turn
    bool closed = false;
  };
  static_assert(std::has_unique_object_representations_v<State> && std::atomic<State>::is_always_lock_free);

  /// The state of the thread with the role at a check by the own thread.
  struct Look {
    bool seemed_idle = false;
    std::uint64_t turns = 0;  ///< value of `turns_` at the check
  };

  /// Applies `change` to the state. `change` may be called several times.
  template <class Change>
  void update(Change change);
  /// Applies `change` to the state, like update(). If `change` returns false, the state stays as it is, and
  /// the function returns false.
  template <class Change>
  bool update_if(Change change);
  Look look(const State& state, Time now, bool readable) const;
  Time next_look(Time now) const;

  std::atomic<State> state_{};
  std::atomic<bool> alarm_set_{false};
  std::atomic<std::uint64_t> turns_{0};  ///< number of turns that have ended
  std::atomic<Time> next_deadline_{Time::max()};
  std::atomic<Time> last_used_{Time::min()};  ///< time when a waiting thread last used the role
  Look last_look_;                            ///< state of the thread with the role at the last check
};

}  // namespace sft::udp
