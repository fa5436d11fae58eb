// Decides which thread receives: the transport's own thread, or a thread that waits for a sample and takes
// it straight from the socket. Uses no clock, thread or I/O of its own. Any thread may call it.
//
// One waiting thread has the role at a time, and keeps it while it sleeps on the socket. When it leaves
// with its sample, the role stays vacant for a moment. The thread will most likely be back soon, and then
// no thread had to be woken. Meanwhile the own thread stands by. It takes the role back if no thread came,
// if another thread waits, if a listener has to be called at once, or if the holder does nothing although
// there is work: a signal handler or a debugger can stop a thread.
//
// The role is passed on and never withdrawn for good. So it is neither a GuardedCall nor a Published value
// (core/sync): a thread that waits for the end of a turn only needs the next turn to belong to another
// thread.
//
// The class has no mutex, because a thread that spins would sleep whenever the own thread held the mutex.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <type_traits>

namespace sft::udp {

class ReceivingRole {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The role stays vacant for this time, for the last holder to come back.
  static constexpr std::chrono::milliseconds vacancy{1};
  /// Pause between checks of a holder by the own thread.
  static constexpr std::chrono::milliseconds look_period{50};
  /// Pause between checks of a holder that seems to do nothing.
  static constexpr std::chrono::milliseconds second_look{2};
  /// After this time without waiting threads, the transport's own thread sleeps in the kernel again. Then
  /// the next waiting thread has to wake it.
  static constexpr std::chrono::seconds own_again{1};

  // The result of enter(). A waiting thread calls enter(), then begin() and end() any number of times, then
  // leave().

  enum class Entry : std::uint8_t {
    taken,  ///< begin() may be called
    /// Begin() may be called once the own thread has passed the role on; the caller has to wake that
    /// thread.
    promised,
    occupied,  ///< another thread has the role; the caller calls wait_behind() until the doorbell rings
    refused,   ///< the role is not given to waiting threads at present
  };
  Entry enter(Time now);
  /// Begins a turn, in which no other thread receives until end(). Returns false if the calling thread does
  /// not have the role.
  bool begin();
  void end(Time next_deadline);
  /// Returns true if the calling thread neither has the role nor has been promised it.
  bool lost() const;

  struct Leaving {
    bool set_alarm = false;  ///< true if the own thread has to check the role at the end of the vacancy
    bool wake = false;       ///< true if the own thread has to check the role now
  };
  Leaving leave(Time now);

  /// Registers a thread that was denied the role and sleeps until unwait_behind(). Returns true if the
  /// caller has to wake the own thread.
  [[nodiscard]] bool wait_behind();
  void unwait_behind();

  /// Registers a reader whose listener must be called at once, and only by the own thread. As long as there
  /// is such a reader, no other thread gets the role. Returns true if the caller has to wake both the
  /// thread that has the role and the own thread.
  [[nodiscard]] bool add_attended();
  void remove_attended();

  // The following functions are for the transport's own thread.

  enum class Duty : std::uint8_t {
    receive,   ///< a turn has begun; the thread may sleep in it, since no other thread waits
    poll,      ///< the thread waits, and calls take_turn() when a datagram has come
    stand_by,  ///< the thread waits until the deadline
    stop,
  };
  struct Task {
    Duty duty = Duty::receive;
    Time until = Time::max();
    bool evicts = false;  ///< true if another thread has lost the role by this call and has to be woken
  };
  /// Returns the next task. `readable` is true if there are datagrams in the socket.
  Task next(Time now, bool readable);
  /// Called after `poll`. Returns false if a waiting thread took the role meanwhile.
  bool take_turn();
  /// Ends the turn. Returns true if a waiting thread has the role now and has to be woken.
  [[nodiscard]] bool end_turn(Time next_deadline);
  /// Notes that the own thread's alarm has rung.
  void alarm_rang();

  /// Ends receiving, without waiting for any thread. Any thread may call this.
  void close();
  /// Returns true if a waiting thread is receiving. Its turn ends soon, even after close() and
  /// add_attended().
  bool waiter_in_turn() const;

 private:
  enum class Holder : std::uint8_t { own, waiter, nobody };
  /// States if a thread is between enter() and leave(). With `awaited_waiter`, that thread has been
  /// promised the role.
  enum class Inside : std::uint8_t { nobody, somebody, awaited_waiter };

  /// The whole state that decides which thread may receive. It is one word, so that it changes atomically.
  struct State {
    std::uint16_t attended = 0;
    std::uint16_t behind = 0;
    Holder holder = Holder::own;
    Inside inside = Inside::nobody;
    bool in_turn = false;  ///< true if the holder is receiving
    bool closed = false;
  };
  static_assert(std::has_unique_object_representations_v<State> && std::atomic<State>::is_always_lock_free);

  /// The state of a holder at a check by the own thread.
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
  Look last_look_;                            ///< state of the holder at the last check
};

}  // namespace sft::udp
