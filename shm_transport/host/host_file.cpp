#include "shm_transport/host/host_file.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <sstream>

#include "shm_transport/host/socket_address.h"

namespace sft::shm {

namespace {

constexpr const char* digits = "0123456789abcdef";

/// Converts hex digits to bytes, and skips all other characters (the dashes of a UUID). Returns whether the
/// text has exactly as many digits as the bytes need.
bool from_hex(std::string_view text, std::span<std::uint8_t> bytes) {
  std::size_t nibbles = 0;
  for (const char c : text) {
    const char* digit = c == '\0' ? nullptr : std::strchr(digits, c);
    if (digit == nullptr) continue;
    if (nibbles == 2 * bytes.size()) return false;
    bytes[nibbles / 2] = static_cast<std::uint8_t>(bytes[nibbles / 2] << 4 | (digit - digits));
    ++nibbles;
  }
  return nibbles == 2 * bytes.size();
}

template <class Number>
bool from_decimal(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

bool take_line(HostFile& file, std::string_view key, std::string_view value) {
  if (key == "token") return from_hex(value, file.token);
  if (key == "pid") return from_decimal(value, file.pid);
  if (key == "ports") return from_decimal(value, file.port_pool_offset);
  if (key == "protocol") return from_decimal(value, file.protocol);
  if (key == "segment_id") return from_decimal(value, file.segment_id);
  if (key == "segment_bytes") return from_decimal(value, file.segment_bytes);
  if (key == "readers") return from_decimal(value, file.readers.emplace());
  if (key == "segment") {
    file.segment = value;
    return value.find('/') == std::string_view::npos;
  }
  return true;  // an unknown key, from a later version
}

}  // namespace

bool is_runtime_name(std::string_view name) noexcept {
  return name.starts_with(runtime_name_stem) && name.find('/') == std::string_view::npos;
}

std::string pid_namespace_mark() {
  struct stat own {};
  return stat("/proc/self/ns/pid", &own) == 0 ? "_" + std::to_string(own.st_ino) : "";
}

std::string format(const HostFile& file) {
  std::string text = "token ";
  for (const std::uint8_t byte : file.token) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  text += "\npid " + std::to_string(file.pid);
  text += "\nprotocol " + std::to_string(file.protocol);
  text += "\nports " + std::to_string(file.port_pool_offset);
  if (!file.segment.empty()) {
    text += "\nsegment " + file.segment;
    text += "\nsegment_id " + std::to_string(file.segment_id);
    text += "\nsegment_bytes " + std::to_string(file.segment_bytes);
  }
  if (file.readers) text += "\nreaders " + std::to_string(*file.readers);
  return text + "\nend\n";
}

std::optional<HostFile> parse_host_file(std::string_view text) {
  HostFile file;
  bool has_token = false;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line == "end") return has_token ? std::optional(file) : std::nullopt;
    const std::string_view key = line.substr(0, line.find(' '));
    if (key.size() == line.size() || !take_line(file, key, line.substr(key.size() + 1))) return std::nullopt;
    has_token |= key == "token";
  }
  return std::nullopt;
}

HostMonitor::Look HostMonitor::look(const core::TrustedAccounts& accepted) {
  auto descriptor = core::open_trusted_file(host_file_path, O_RDONLY, {.everybody = true});
  struct stat opened {};
  if (!descriptor || !is_locked(descriptor->get()) || fstat(descriptor->get(), &opened) != 0) return {};
  if (!accepted.include_user(opened.st_uid)) return {.finding = Finding::foreign, .user = opened.st_uid};
  char text[1024];
  const ssize_t bytes = pread(descriptor->get(), text, sizeof text, 0);
  const auto file = parse_host_file({text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))});
  if (!file) return {.finding = Finding::starting};
  return {.finding = Finding::alive, .monitor = HostMonitor(std::move(*descriptor), *file, opened.st_uid)};
}

std::string format_lock(const DaemonLock& lock) {
  return "pid " + std::to_string(lock.pid) + "\nshm_device " + std::to_string(lock.shm_device) + "\n";
}

bool DaemonLock::serves_this_shm() const {
  struct stat shm {};
  return pid != 0 && stat("/dev/shm", &shm) == 0 && shm.st_dev == shm_device;
}

std::optional<DaemonLock> read_daemon_lock() {
  const auto file = core::open_trusted_file(daemon_lock_path, O_RDONLY, {.everybody = true});
  struct stat opened {};
  if (!file || !is_locked(file->get()) || fstat(file->get(), &opened) != 0) return std::nullopt;
  char text[256];
  const ssize_t bytes = pread(file->get(), text, sizeof text, 0);
  DaemonLock lock{.user = opened.st_uid};
  std::istringstream words(std::string(text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))));
  for (std::string key; words >> key;) {
    if (key == "pid") words >> lock.pid;
    if (key == "shm_device") words >> lock.shm_device;
  }
  return lock;
}

std::string names_are_gone(pid_t daemon) {
  return "the files of sftd (pid " + std::to_string(daemon) +
         ") were removed from /dev/shm or /tmp (a clean-up script, or systemd's RemoveIPC= at log-out), so "
         "that no "
         "program can "
         "join it; sftd starts afresh in a moment";
}

core::HostToken host_token(const HostFile& file) {
  core::HostToken token;
  std::string boot_id;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot_id;
  const std::span<std::uint8_t> bytes(token.bytes);
  from_hex(boot_id, bytes.first(16));
  std::ranges::copy(file.token, bytes.begin() + 16);
  return token;
}

SocketState socket_state_at(const char* path) noexcept {
  const Descriptor probe(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_un address = socket_address(path);
  if (!probe) return SocketState::unknown;
  if (connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
    return SocketState::alive;
  return errno == ENOENT || errno == ECONNREFUSED ? SocketState::gone : SocketState::unknown;
}

}  // namespace sft::shm
