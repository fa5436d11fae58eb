// Decides which thread receives: the transport's own thread, or a thread that waits for a sample and takes
// it straight from the socket. Uses no clock, thread or I/O of its own. Any thread may call it.
//
// One waiting thread has the role at a time, and keeps it while it sleeps on the socket. When it leaves
// with its sample, the role stays vacant for a moment, since the thread will most likely be back, and then
// no thread had to be woken. Meanwhile the own thread stands by. It takes the role back if no thread came,
// if another thread waits, if a listener has to be called at once, or if the holder does nothing although
// there is something to do: a signal handler or a debugger can hold up a thread.
//
// The role is passed on and never taken away for good. So it is neither a GuardedCall nor a Published value
// (core/sync): a thread that waits for the end of a turn only wants the next turn to be another thread's.
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

  static constexpr std::chrono::milliseconds vacancy{1};  ///< time in which the last holder may be back
  /// Pause between checks of a holder by the own thread.
  static constexpr std::chrono::milliseconds look_period{50};
  /// Pause between checks of a holder that seems to do nothing.
  static constexpr std::chrono::milliseconds second_look{2};
  /// After this time without waiting threads the transport's own thread stays in the kernel again. Then the
  /// next waiting thread has to wake it.
  static constexpr std::chrono::seconds own_again{1};

  // A waiting thread calls enter(), then begin() and end() as often as it likes, then leave().

  enum class Entry : std::uint8_t {
    taken,     ///< begin() may be called
    promised,  ///< begin() may be called once the own thread has passed the role on; the caller wakes it
    occupied,  ///< another thread has the role; the caller calls wait_behind() until the doorbell rings
    refused,   ///< the role is not given to waiting threads at present
  };
  Entry enter(Time now);
  /// Begins a turn: no other thread receives until end(). Returns false if this thread does not have the
  /// role.
  bool begin();
  void end(Time next_deadline);
  /// Returns true if this thread neither has the role nor has been promised it.
  bool lost() const;

  struct Leaving {
    bool set_alarm = false;  ///< the own thread has to check the role at the end of the vacancy
    bool wake = false;       ///< the own thread has to check the role now
  };
  Leaving leave(Time now);

  /// Registers a thread that was denied the role and sleeps until unwait_behind(). Returns true if the own
  /// thread has to be woken.
  [[nodiscard]] bool wait_behind();
  void unwait_behind();

  /// Registers a reader whose listener must be called at once, and only by the own thread. As long as there
  /// is such a reader, no other thread gets the role. Returns true if the thread that has the role, and the
  /// own thread, have to be woken.
  [[nodiscard]] bool add_attended();
  void remove_attended();

  // The transport's own thread.

  enum class Duty : std::uint8_t {
    receive,   ///< a turn has begun, in which the thread may sleep, since it is alone
    poll,      ///< the thread waits, and calls take_turn() when something is there
    stand_by,  ///< the thread waits until the deadline
    stop,
  };
  struct Task {
    Duty duty = Duty::receive;
    Time until = Time::max();
    bool evicts = false;  ///< a thread lost the role by this and has to be woken
  };
  /// `readable`: there are datagrams in the socket.
  Task next(Time now, bool readable);
  /// Called after `poll`. Returns false if a waiting thread took the role meanwhile.
  bool take_turn();
  /// Returns true if a waiting thread has the role now and has to be woken.
  [[nodiscard]] bool end_turn(Time next_deadline);
  /// Notes that the own thread's alarm has rung.
  void alarm_rang();

  /// Ends receiving, without waiting for any thread. Any thread.
  void close();
  /// Returns true if a waiting thread is receiving. Its turn ends soon, also after close() and
  /// add_attended().
  bool waiter_in_turn() const;

 private:
  enum class Holder : std::uint8_t { own, waiter, nobody };
  /// Whether a thread is between enter() and leave(); `awaited_waiter`: that thread has been promised the
  /// role.
  enum class Inside : std::uint8_t { nobody, somebody, awaited_waiter };

  /// The whole state that decides who may receive, in one word, so that it changes atomically.
  struct State {
    std::uint16_t attended = 0;
    std::uint16_t behind = 0;
    Holder holder = Holder::own;
    Inside inside = Inside::nobody;
    bool in_turn = false;  ///< the holder is receiving
    bool closed = false;
  };
  static_assert(std::has_unique_object_representations_v<State> && std::atomic<State>::is_always_lock_free);

  /// What the own thread remembers about a holder.
  struct Look {
    bool seemed_idle = false;
    std::uint64_t turns = 0;  ///< value of `turns_` at that time
  };

  /// Applies `change` to the state. It may be called several times.
  template <class Change>
  void update(Change change);
  /// Like update(), but if `change` returns false, the state stays as it is, and update_if() returns false.
  template <class Change>
  bool update_if(Change change);
  Look look(const State& state, Time now, bool readable) const;
  Time next_look(Time now) const;

  std::atomic<State> state_{};
  std::atomic<bool> alarm_set_{false};
  std::atomic<std::uint64_t> turns_{0};  ///< number of turns that have ended
  std::atomic<Time> next_deadline_{Time::max()};
  std::atomic<Time> last_used_{Time::min()};  ///< when a waiting thread used the role last
  Look last_look_;                            ///< what the own thread saw last
};

}  // namespace sft::udp
