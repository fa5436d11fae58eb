// What becomes of a node in a process that the program forks. The new process has a copy of the node's
// memory, but none of its threads, and it shares the node's sockets, files and shared memory with its parent.
// So what the copy does not touch is best: destroying a node there, or what it has opened or lent, does
// nothing.
#pragma once

namespace sft::core {

/// A member of everything that is of one process only. A process that is forked while any of it lives is a
/// copy.
class OfOneProcess {
 public:
  OfOneProcess() noexcept;
  ~OfOneProcess();
  OfOneProcess(const OfOneProcess&) = delete;
  OfOneProcess& operator=(const OfOneProcess&) = delete;
};

/// Whether this process was forked, directly or not, from one in which a node lived, and has not begun
/// another program since.
bool is_forked_copy() noexcept;

}  // namespace sft::core
