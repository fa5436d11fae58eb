// A node that runs in its own process on an emulated host.
#pragma once

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sft/sft.h>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <functional>
#include <new>

#include "tools/hosts/network.h"

namespace sft::test {

/// An object of type T that this process shares with the processes that it forks later. The members of T are
/// atomic.
template <class T>
class SharedWithChildren {
 public:
  SharedWithChildren()
      : value_(new (mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) T) {}
  ~SharedWithChildren() { munmap(value_, sizeof(T)); }
  SharedWithChildren(const SharedWithChildren&) = delete;
  SharedWithChildren& operator=(const SharedWithChildren&) = delete;

  T& operator*() const { return *value_; }
  T* operator->() const { return value_; }

 private:
  T* value_;
};

/// A process that opens a node, and calls its role, a function of the test, with this node again and again.
/// The role writes its progress to a report. The destructor kills the process.
template <class Report>
class NodeProcessWith {
 public:
  using Role = std::function<void(Node& node, Report& report)>;

  NodeProcessWith(const hosts::NetworkNamespace& host, const NodeOptions& options, const Role& role) {
    process_ = fork();
    if (process_ == 0) run(host, options, role);
  }
  ~NodeProcessWith() { kill_now(); }
  NodeProcessWith(const NodeProcessWith&) = delete;
  NodeProcessWith& operator=(const NodeProcessWith&) = delete;

  void kill_now() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  /// Stops the process, as a debugger or a busy machine would do.
  void hold_up() const { kill(process_, SIGSTOP); }
  void let_go() const { kill(process_, SIGCONT); }
  Report& report() const { return *report_; }
  pid_t id() const { return process_; }

 private:
  [[noreturn]] void run(const hosts::NetworkNamespace& host, const NodeOptions& options, const Role& role) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    auto node = host.enter() ? Node::open(options) : fail(Errc::system, "the host cannot be entered");
    if (node) {
      for (;;) role(*node, *report_);
    }
    std::fprintf(stderr, "%s\n", node.error().message.c_str());
    report_->failed = true;
    for (;;) pause();
  }

  SharedWithChildren<Report> report_;
  pid_t process_ = -1;
};

}  // namespace sft::test
