// A program that has nodes may fork. The new process has a copy of the node's memory, but none of its
// threads, and it shares the node's sockets, files and shared memory with its parent. The copy must not use
// any of these. Therefore the destruction of a node, or of an object that the node has opened or lent, does
// nothing in the copy.
#pragma once

namespace sft::core {

/// A member of each object that works only in the process that made it. A process that is forked while any
/// such object lives is a copy.
class OfOneProcess {
 public:
  OfOneProcess() noexcept;
  ~OfOneProcess();
  OfOneProcess(const OfOneProcess&) = delete;
  OfOneProcess& operator=(const OfOneProcess&) = delete;
};

/// Returns true if this process was forked, directly or indirectly, from a process in which a node lived, and
/// has not executed another program since.
bool is_forked_copy() noexcept;

/// The text of the error that functions return in a forked copy.
inline constexpr const char* refuses_forked_copies =
    "this process was forked from one that has a node: open nodes only after fork(), or begin another "
    "program in the new process (exec)";

}  // namespace sft::core
