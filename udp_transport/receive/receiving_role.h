// Decides which thread receives: the transport's own thread, or a thread that waits for a sample and takes it
// straight from the socket. Pure: times in, decisions out; no I/O, no clock. Any thread.
//
// One waiting thread has the role at a time, and keeps it while it sleeps on the socket. When it has its
// sample and goes, the role stays vacant for a moment, since it will most likely be back: then nobody was
// woken for it. The own thread meanwhile stands by. It takes the role back when nobody came, when somebody
// else waits or has to be told at once, and when the holder does nothing although there is something to do: a
// thread can be held up by a signal handler or a debugger.
//
// The role is passed on and never taken away for good, so that it is neither a GuardedCall nor a Published
// value (core/sync): whoever waits for the end of a turn only wants the next turn to be another thread's.
//
// It has no mutex: a thread that waits with its core kept busy would sleep whenever the own thread held it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <type_traits>

namespace sft::udp {

class ReceivingRole {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::milliseconds vacancy{1};       ///< in which the last holder may be back
  static constexpr std::chrono::milliseconds look_period{50};  ///< at a holder, by the thread that stands by
  static constexpr std::chrono::milliseconds second_look{2};   ///< at one that seems to do nothing
  /// After this time without waiting threads the transport's own thread stays in the kernel again. The next
  /// waiting thread has to wake it.
  static constexpr std::chrono::seconds own_again{1};

  // A waiting thread: enter(), begin() and end() as often as it likes, leave().

  enum class Entry : std::uint8_t {
    taken,     ///< begin() may be called
    promised,  ///< begin() may be called once the own thread has passed the role on; wake the own thread
    occupied,  ///< another thread has the role: wait_behind() until the doorbell rings
    refused,   ///< the role is not given to waiting threads at present
  };
  Entry enter(Time now);
  /// Nobody else receives until end(). False if the role is not, or not yet, or no longer this thread's.
  bool begin();
  void end(Time next_deadline);
  /// This thread neither holds the role nor has been promised it.
  bool lost() const;

  struct Leaving {
    bool set_alarm = false;  ///< the own thread has to look here when the vacancy is over
    bool wake = false;       ///< it has to look here now
  };
  Leaving leave(Time now);

  /// Registers a thread that was denied the role and sleeps until unwait_behind(). True: the own thread has
  /// to be woken.
  [[nodiscard]] bool wait_behind();
  void unwait_behind();

  /// Registers a reader whose listener must be called at once, and by the own thread only. As long as there
  /// is such a reader, no other thread gets the role. True: the thread that has the role, and the own thread,
  /// have to be woken.
  [[nodiscard]] bool add_attended();
  void remove_attended();

  // The own thread.

  enum class Duty : std::uint8_t {
    receive,   ///< alone: a turn of it has begun, in which it may sleep
    poll,      ///< and take_turn() when something is there
    stand_by,  ///< wait until the deadline
    stop,
  };
  struct Task {
    Duty duty = Duty::receive;
    Time until = Time::max();
    bool evicts = false;  ///< somebody lost the role by this: wake it
  };
  /// `readable`: something waits in the socket.
  Task next(Time now, bool readable);
  /// After `poll`: false if a waiting thread took the role in between.
  bool take_turn();
  /// True: a waiting thread has the role now and has to be woken.
  [[nodiscard]] bool end_turn(Time next_deadline);
  /// The own thread's alarm has rung.
  void alarm_rang();

  /// Nobody receives any more; waits for no one. Any thread.
  void close();
  /// A waiting thread is receiving. Its turn ends soon, also after close() and add_attended().
  bool waiter_in_turn() const;

 private:
  enum class Holder : std::uint8_t { own, waiter, nobody };
  /// Says whether a thread is between enter() and leave().
  enum class Inside : std::uint8_t { nobody, somebody, awaited_waiter };

  /// All that decides who may receive, in one word, so that it changes at once.
  struct State {
    std::uint16_t attended = 0;
    std::uint16_t behind = 0;
    Holder holder = Holder::own;
    Inside inside = Inside::nobody;
    bool in_turn = false;  ///< the holder is receiving
    bool closed = false;
  };
  static_assert(std::has_unique_object_representations_v<State> && std::atomic<State>::is_always_lock_free);

  /// The own thread remembers this of a holder that seemed idle.
  struct Look {
    bool seemed_idle = false;
    std::uint64_t turns = 0;  ///< at that time
  };

  /// `change` gets the state. It may be called several times.
  template <class Change>
  void update(Change change);
  /// `change` returns false if the state is to stay as it is. Then update_if() returns false, too.
  template <class Change>
  bool update_if(Change change);
  Look look(const State& state, Time now, bool readable) const;
  Time next_look(Time now) const;

  std::atomic<State> state_{};
  std::atomic<bool> alarm_set_{false};
  std::atomic<std::uint64_t> turns_{0};  ///< that have ended
  std::atomic<Time> next_deadline_{Time::max()};
  std::atomic<Time> last_used_{Time::min()};  ///< by a waiting thread
  Look last_look_;                            ///< the own thread's
};

}  // namespace sft::udp
