#include "tests/hostile/daemon_acts.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "core/platform/doorbell.h"
#include "tests/hostile/forged_control.h"
#include "tests/hostile/names.h"

namespace sft::hostile {

namespace fs = std::filesystem;

namespace {

void signal_all(const std::vector<pid_t>& processes, int number) {
  for (const pid_t process : processes) kill(process, number);
}

/// An sftd of the attacker, which is started again whenever it ends.
class OwnDaemon {
 public:
  void keep_running() {
    if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == 0) return;
    const std::string path = fs::read_symlink("/proc/self/exe").parent_path() / "sftd";
    std::string words[] = {path, "--foreground", "--pool-mib=32", "--log-level=error"};
    char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
    if (posix_spawn(&pid_, path.c_str(), nullptr, nullptr, arguments, environ) != 0) pid_ = -1;
  }
  void end(int number) {
    if (pid_ <= 0) return;
    kill(pid_, number);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
};

/// Calls `use` for all files and sockets of this account in the directories of shared memory.
void for_each_own_file(const std::function<void(const std::string&)>& use) {
  for (const char* directory : {"/dev/shm", "/tmp"}) {
    std::error_code ignored;
    for (const auto& entry : fs::recursive_directory_iterator(
             directory, fs::directory_options::skip_permission_denied, ignored)) {
      struct stat file {};
      if (lstat(entry.path().c_str(), &file) == 0 && file.st_uid == getuid()) use(entry.path());
    }
  }
}

void remove_own_files() {
  std::vector<std::string> files;
  for_each_own_file([&](const std::string& path) { files.push_back(path); });
  for (const std::string& path : files) unlink(path.c_str());
}

Act daemon_that(std::function<void()> also, int end_signal) {
  const auto daemon = std::make_shared<OwnDaemon>();
  return {.begin = {},
          .go_on =
              [daemon, also = std::move(also)] {
                daemon->keep_running();
                if (also) also();
              },
          .end = [daemon, end_signal] { daemon->end(end_signal); }};
}

void open_own_files_to_all() {
  for_each_own_file([](const std::string& path) { chmod(path.c_str(), 0777); });
}

/// An attacker that announces a reader which seems to share the memory of the publisher's host.
class FalseNeighbour {
 public:
  explicit FalseNeighbour(Random& random) : random_(random), node_(random() | 1), forged_control_(node_) {}

  /// Announces the reader once to each publisher. `make_page` gets the path of the reader's doorbell page.
  void announce_to_all(const std::function<void(const std::string&)>& make_page) {
    for (const core::Endpoint& writer : forged_control_.heard(core::Role::writer)) {
      if (!writer.host.known() || !known_.insert({writer.id, writer.host.bytes}).second) continue;
      core::Endpoint reader = made_up_reader(writer, random_(), node_, {});
      reader.host = writer.host;
      reader.network = writer.network;
      reader.may_use_memory = true;
      reader.may_use_network = false;
      reader.doorbell = {random_(), 0};
      reader.request.listening.clear();
      reader.request.attached = {writer.id};
      pages.push_back(core::DoorbellPage::path_of(reader.doorbell.page));
      make_page(pages.back());
      forged_control_.announce(reader);
    }
    forged_control_.live();
  }

  std::vector<std::string> pages;

 private:
  Random& random_;
  std::uint64_t node_;
  ForgedControl forged_control_;
  std::set<std::pair<core::EndpointId, std::array<std::uint8_t, 32>>> known_;
};

Act doorbell_that(Target& target, std::function<void(const std::string&)> make,
                  std::function<void(const std::string&)> change = {}) {
  const auto neighbour = std::make_shared<FalseNeighbour>(target.random);
  const auto ticks = std::make_shared<int>(0);
  return {.begin = {},
          .go_on =
              [=] {
                neighbour->announce_to_all(make);
                constexpr int ticks_to_be_served = 30;
                if (!change || ++*ticks < ticks_to_be_served) return;
                for (const std::string& page : neighbour->pages) change(page);
              },
          .end =
              [=] {
                for (const std::string& page : neighbour->pages) unlink(page.c_str());
              }};
}

/// Makes a file with the length of a doorbell page.
void make_page(const std::string& path) {
  const int page = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  if (page < 0 || ftruncate(page, core::DoorbellPage::slots * sizeof(core::Doorbell)) != 0) return;
  close(page);
}

/// Removes all files of this account in the directory.
void remove_all_in(const char* directory) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(directory, ignored)) remove_quietly(entry.path());
}

/// Limits the file descriptors of processes so that they cannot open further ones. A process is limited
/// only after it has run for a moment, so that its start does not fail.
class DescriptorLimits {
 public:
  void impose(const std::vector<pid_t>& processes) {
    constexpr int ticks_to_start = 30;
    for (const pid_t process : processes) {
      if (++seen_[process] != ticks_to_start) continue;
      rlimit limit{};
      if (prlimit(process, RLIMIT_NOFILE, nullptr, &limit) != 0) continue;
      before_[process] = limit;
      limit.rlim_cur = 3;
      prlimit(process, RLIMIT_NOFILE, &limit, nullptr);
    }
  }
  void lift() {
    for (const auto& [process, limit] : before_) prlimit(process, RLIMIT_NOFILE, &limit, nullptr);
  }

 private:
  std::map<pid_t, int> seen_;
  std::map<pid_t, rlimit> before_;
};

}  // namespace

Act own_daemon(Target&) { return daemon_that({}, SIGTERM); }

Act own_daemon_open_to_all(Target&) { return daemon_that(open_own_files_to_all, SIGTERM); }

Act own_daemon_that_shrinks(Target&) {
  const auto shrink = [ticks = 0]() mutable {
    open_own_files_to_all();
    constexpr int ticks_to_be_found = 50;
    if (++ticks < ticks_to_be_found) return;
    for_each_own_file([](const std::string& path) { (void)!truncate(path.c_str(), 0); });
  };
  Act act = daemon_that(shrink, SIGKILL);
  act.end = [end = act.end] {
    end();
    remove_own_files();
  };
  return act;
}

Act own_daemon_that_is_killed(Target&) { return daemon_that({}, SIGKILL); }

Act shrinking_doorbell(Target& target) {
  return doorbell_that(target, make_page, [](const std::string& page) { (void)!truncate(page.c_str(), 0); });
}

Act doorbell_fifo(Target& target) {
  return doorbell_that(target, [](const std::string& page) { mkfifo(page.c_str(), 0666); });
}

Act doorbell_of_nobody(Target& target) {
  return doorbell_that(target, [](const std::string&) {});
}

/// Makes the announced page a link to a page at which an honest reader waits.
Act doorbells_of_the_honest(Target& target) {
  return doorbell_that(target, [](const std::string& page) {
    for (const std::string& honest : shared_files("sft_bell")) (void)!symlink(honest.c_str(), page.c_str());
  });
}

Act removed_doorbells(Target&) {
  return {.begin = [] {
    for (const std::string& page : shared_files("sft_bell")) remove_quietly(page);
  }};
}

Act removed_shared_memory(Target&) {
  return {.begin = [] { remove_all_in("/dev/shm"); }};
}

Act removed_tmp(Target&) {
  return {.begin = [] { remove_all_in("/tmp"); }};
}

Act killed_daemon(Target&) {
  return {.begin = [] { signal_all(processes("sftd"), SIGKILL); }};
}

Act daemon_killed_often(Target&) {
  return {.begin = {}, .go_on = [ticks = 0]() mutable {
            constexpr int ticks_between = 15;
            if (++ticks % ticks_between == 0) signal_all(processes("sftd"), SIGKILL);
          }};
}

Act stopped_daemon(Target&) {
  return {.begin = [] { signal_all(processes("sftd"), SIGSTOP); },
          .go_on = {},
          .end = [] { signal_all(processes("sftd"), SIGCONT); }};
}

Act ended_daemon(Target&) {
  return {.begin = [] { signal_all(processes("sftd"), SIGTERM); }};
}

Act stopped_near_reader(Target&) {
  return {.begin = [] { signal_all(honest_program("near"), SIGSTOP); },
          .go_on = {},
          .end = [] { signal_all(honest_program("near"), SIGCONT); }};
}

Act no_descriptors(Target&) {
  const auto limits = std::make_shared<DescriptorLimits>();
  return {.begin = {},
          .go_on = [limits] { limits->impose(honest_program("publisher")); },
          .end = [limits] { limits->lift(); }};
}

}  // namespace sft::hostile
