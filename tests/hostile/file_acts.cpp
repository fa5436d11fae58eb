#include "tests/hostile/file_acts.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/hostile/names.h"

namespace sft::hostile {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t block_bytes = 1024 * 1024;

/// Returns an act that calls `put` for each free name, and at the end removes what `put` has made.
Act at_every_name(const Target& target, std::function<bool(const std::string&)> put) {
  const auto taken = std::make_shared<std::vector<std::string>>();
  const auto take = [names = names_of(target.account), put = std::move(put), taken] {
    umask(0);
    for (const std::string& name : names) {
      struct stat there {};
      if (lstat(name.c_str(), &there) != 0 && put(name)) taken->push_back(name);
    }
  };
  return {.begin = take, .go_on = take, .end = [taken] {
            for (const std::string& name : *taken) remove_quietly(name);
          }};
}

bool make_file(const std::string& path, mode_t mode) {
  const int file = open(path.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, mode);
  if (file >= 0) close(file);
  return file >= 0;
}

bool make_socket(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  const int listener = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);  // stays open and never answers
  return bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

/// Returns the paths of all files in /dev/shm, /tmp and /run that can be opened for reading.
std::vector<std::string> readable_files() {
  std::vector<std::string> files;
  for (const char* directory : {"/dev/shm", "/tmp", "/run"}) {
    std::error_code ignored;
    for (const auto& entry : fs::recursive_directory_iterator(
             directory, fs::directory_options::skip_permission_denied, ignored)) {
      std::error_code unreadable;
      if (entry.is_regular_file(unreadable) && access(entry.path().c_str(), R_OK) == 0)
        files.push_back(entry.path());
    }
  }
  return files;
}

/// Returns an act that writes a file until no space is left, and frees the space at the end.
Act filled(const std::string& path) {
  const auto fill = [path] {
    const std::string block(block_bytes, 'x');
    const int file = open(path.c_str(), O_CREAT | O_APPEND | O_WRONLY | O_CLOEXEC, 0600);
    for (std::size_t n = block.size(); n > 0; n /= 2) {
      while (write(file, block.data(), n) > 0) continue;
    }
    close(file);
  };
  return {.begin = fill, .go_on = fill, .end = [path] { remove_quietly(path); }};
}

struct OpenFiles {
  std::vector<int> descriptors;
  ~OpenFiles() { clear(); }
  void clear() {
    for (const int file : descriptors) close(file);
    descriptors.clear();
  }
};

/// Returns an act that opens each readable file once, and calls `how` with the descriptor of the file to
/// lock it.
Act locks(std::function<void(int)> how) {
  const auto locked = std::make_shared<OpenFiles>();
  const auto known = std::make_shared<std::vector<std::string>>();
  const auto lock_all = [=] {
    for (const std::string& path : readable_files()) {
      struct stat file {};
      if (stat(path.c_str(), &file) != 0) continue;
      const std::string identity = path + std::to_string(file.st_ino);
      if (std::find(known->begin(), known->end(), identity) != known->end()) continue;
      known->push_back(identity);
      const int descriptor = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
      if (descriptor < 0) continue;
      locked->descriptors.push_back(descriptor);
      how(descriptor);
    }
  };
  return {.begin = lock_all, .go_on = lock_all, .end = [locked] { locked->clear(); }};
}

struct flock whole_file_read_lock() {
  struct flock lock {};
  lock.l_type = F_RDLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

}  // namespace

Act fifos(Target& target) {
  return at_every_name(target, [](const std::string& path) { return mkfifo(path.c_str(), 0666) == 0; });
}

Act directories(Target& target) {
  return at_every_name(target, [](const std::string& path) {
    return mkdir(path.c_str(), 0777) == 0 && make_file(path + "/mine", 0600);
  });
}

Act dangling_links(Target& target) {
  return at_every_name(target,
                       [](const std::string& path) { return symlink("/tmp/nowhere", path.c_str()) == 0; });
}

Act links_to_files_of_the_honest(Target& target) {
  return at_every_name(target,
                       [](const std::string& path) { return symlink("/proc/self/exe", path.c_str()) == 0; });
}

Act closed_files(Target& target) {
  return at_every_name(target, [](const std::string& path) { return make_file(path, 0600); });
}

Act open_files(Target& target) {
  return at_every_name(target, [](const std::string& path) { return make_file(path, 0666); });
}

Act hard_links(Target& target) {
  return at_every_name(target, [](const std::string& path) {
    const std::string other = path + ".other";
    make_file(other, 0666);
    return link(other.c_str(), path.c_str()) == 0;
  });
}

Act sockets(Target& target) { return at_every_name(target, make_socket); }

/// Does the same as fifos(), but repeatedly, as soon as a name becomes free.
Act snatched_names(Target& target) {
  Act act = fifos(target);
  act.go_on = [snatch = act.go_on] {
    for (int i = 0; i < 300; ++i) snatch();
  };
  return act;
}

Act read_locks(Target&) {
  return locks([](int descriptor) {
    struct flock lock = whole_file_read_lock();
    fcntl(descriptor, F_OFD_SETLK, &lock);
    flock(descriptor, LOCK_SH | LOCK_NB);
  });
}

/// Requests each lock in a separate process, which waits for the lock. The system grants the lock when the
/// honest holder has released it.
Act waiting_read_locks(Target&) {
  const auto waiting = std::make_shared<std::vector<pid_t>>();
  Act act = locks([waiting](int descriptor) {
    const pid_t process = fork();
    if (process > 0) waiting->push_back(process);
    if (process != 0) return;
    struct flock lock = whole_file_read_lock();
    fcntl(descriptor, F_OFD_SETLKW, &lock);
    for (;;) pause();
  });
  act.end = [waiting, end = act.end] {
    for (const pid_t process : *waiting) kill(process, SIGKILL);
    end();
  };
  return act;
}

Act full_shared_memory(Target&) { return filled("/dev/shm/full"); }

Act full_tmp(Target&) { return filled("/tmp/full"); }

/// Makes empty files until the file system has no inodes left.
Act no_file_numbers(Target&) {
  constexpr int files = 20'000;
  const std::string directory = "/dev/shm/many";
  return {.begin =
              [directory] {
                fs::create_directory(directory);
                for (int i = 0; i < files; ++i) {
                  if (!make_file(directory + "/" + std::to_string(i), 0600)) return;
                }
              },
          .end = [directory] { remove_quietly(directory); }};
}

}  // namespace sft::hostile
