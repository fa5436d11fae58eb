// hostile_actor ACT ACCOUNT SEED: performs the act against the programs of that account until its standard
// input, which is a socket, is closed or receives data. Writes to this socket when the act has begun, and
// at the end what the attacker has gained. `hostile_actor --list` prints all acts. `hostile_actor
// --sftd-status` ends with the exit code of `sftd status`, without its output.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include "tests/hostile/act.h"

namespace sft::hostile {
namespace {

constexpr int pause_ms = 10;

void answer(const std::string& text) { (void)!send(STDIN_FILENO, text.data(), text.size(), MSG_NOSIGNAL); }

/// Returns true if the other side has sent something or closed the socket. Reads the data, because otherwise
/// the other side would get an error instead of the answer.
bool must_end(int within_ms) {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  char word[16];
  return poll(&input, 1, within_ms) > 0 && recv(STDIN_FILENO, word, sizeof word, 0) >= 0;
}

int list() {
  for (const Entry& entry : acts())
    std::printf("%-36.*s %.*s\n", static_cast<int>(entry.name.size()), entry.name.data(),
                static_cast<int>(entry.sentence.size()), entry.sentence.data());
  return 0;
}

int ask_daemon() {
  const std::string path = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "sftd";
  if (std::freopen("/dev/null", "w", stdout) != nullptr) execl(path.c_str(), "sftd", "status", nullptr);
  return 127;
}

int perform(const Entry& entry, Target target) {
  const Act act = entry.make(target);
  if (act.begin) act.begin();
  if (act.go_on) act.go_on();
  answer("begun");
  while (!must_end(pause_ms)) {
    if (act.go_on) act.go_on();
  }
  if (act.end) act.end();
  answer("ended" + (act.loot ? ": " + act.loot() : ""));
  return 0;
}

}  // namespace
}  // namespace sft::hostile

int main(int argc, char** argv) try {
  using namespace sft::hostile;
  const std::string name = argc > 1 ? argv[1] : "--list";
  if (name == "--list") return list();
  if (name == "--sftd-status") return ask_daemon();
  const Entry* entry = find_act(name);
  if (entry == nullptr || argc != 4)
    return std::fprintf(stderr, "hostile_actor: no act '%s'\n", name.c_str()), 2;
  return perform(*entry, {static_cast<uid_t>(std::stoul(argv[2])), Random(std::stoull(argv[3]))});
} catch (const std::exception& error) {
  std::fprintf(stderr, "hostile_actor: %s\n", error.what());
  return 1;
}
