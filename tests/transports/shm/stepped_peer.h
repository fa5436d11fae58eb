// A peer whose main thread runs only as far as the test wants, instruction by instruction. The peer's other
// threads run freely. A peer that stands still between two instructions leaves shared memory in the same
// state as a peer that was killed there.
#pragma once

#include <signal.h>
#include <sys/ptrace.h>
#include <sys/user.h>
#include <sys/wait.h>

#include <cstddef>
#include <cstdint>

#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {

/// The peer calls this once, before its first mark.
inline void let_parent_step() { ptrace(PTRACE_TRACEME, 0, nullptr, nullptr); }
/// The peer calls this at the beginning and at the end of the work that the test steps through.
inline void mark() { raise(SIGTRAP); }

/// Only the thread that started the process may call these functions.
class SteppedPeer {
 public:
  explicit SteppedPeer(const Process& process) : pid_(process.pid()) {}

  /// Waits until the peer has reached its first mark. Returns false if the peer has ended.
  [[nodiscard]] bool comes_to_mark() const { return stands_still() && is_at_mark(); }
  /// Lets the peer run until its next mark. Returns false if the peer has ended.
  [[nodiscard]] bool goes_to_mark() const { return resume(PTRACE_CONT) && is_at_mark(); }
  /// Lets the peer execute one instruction. Returns false if the instruction has brought the peer to its next
  /// mark.
  [[nodiscard]] bool steps() const { return resume(PTRACE_SINGLESTEP) && !is_at_mark(); }
  /// Lets the peer run until it is about to execute the instruction at its breakpoint. Returns false if the
  /// peer reaches its next mark before.
  [[nodiscard]] bool goes_to_breakpoint() const { return resume(PTRACE_CONT) && !is_at_mark(); }

#ifdef __x86_64__
  static constexpr bool has_breakpoints = true;
  /// Returns the address of the instruction that the peer executes next.
  std::uintptr_t instruction() const {
    return static_cast<std::uintptr_t>(ptrace(PTRACE_PEEKUSER, pid_, offsetof(user, regs.rip), nullptr));
  }
  /// Sets a breakpoint in the debug registers of the main thread. The other threads of the peer do not stop
  /// there.
  void set_breakpoint(std::uintptr_t instruction) const {
    ptrace(PTRACE_POKEUSER, pid_, offsetof(user, u_debugreg[0]), instruction);
    ptrace(PTRACE_POKEUSER, pid_, offsetof(user, u_debugreg[7]), 1UL);
  }
  void clear_breakpoint() const { ptrace(PTRACE_POKEUSER, pid_, offsetof(user, u_debugreg[7]), 0UL); }
#else
  static constexpr bool has_breakpoints = false;
  std::uintptr_t instruction() const { return 0; }
  void set_breakpoint(std::uintptr_t) const {}
  void clear_breakpoint() const {}
#endif

 private:
  bool resume(__ptrace_request how) const {
    if (ptrace(how, pid_, nullptr, nullptr) != 0) return false;
    return stands_still();
  }
  bool stands_still() const {
    int status = 0;
    return waitpid(pid_, &status, 0) == pid_ && WIFSTOPPED(status);
  }
  /// Returns true if the peer is at a mark. A single step ends with the same signal, but only at a mark a
  /// thread has sent the signal.
  bool is_at_mark() const {
    siginfo_t signal{};
    return ptrace(PTRACE_GETSIGINFO, pid_, nullptr, &signal) == 0 && signal.si_code == SI_TKILL;
  }

  pid_t pid_;
};

}  // namespace sft::test
