#include "tests/hostile/names.h"
#include "core/platform/text_of.h"

#include <grp.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace sft::hostile {

namespace fs = std::filesystem;
using core::text_of;

namespace {

std::string group_name(gid_t group) {
  const struct group* entry = getgrgid(group);
  return entry == nullptr ? std::to_string(group) : entry->gr_name;
}

}  // namespace

std::vector<std::string> names_of(uid_t account) {
  return {
      "/dev/shm/sft_host", "/dev/shm/sft_status", "/dev/shm/iceoryx_mgmt", "/dev/shm/" + group_name(account),
      "/tmp/sftd.lock",    "/tmp/roudi",          "/tmp/roudi.lock",       "/tmp/iox-unique-roudi.lock"};
}

std::vector<std::string> shared_files(const std::string& prefix) {
  std::vector<std::string> found;
  std::error_code ignored;
  for (const auto& entry :
       fs::recursive_directory_iterator("/dev/shm", fs::directory_options::skip_permission_denied, ignored)) {
    if (entry.path().filename().string().starts_with(prefix)) found.push_back(entry.path());
  }
  return found;
}

void remove_quietly(const fs::path& path) {
  std::error_code ignored;
  fs::remove_all(path, ignored);
}

std::vector<pid_t> processes(const std::string& program) {
  std::vector<pid_t> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string name = entry.path().filename();
    if (!std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c) != 0; })) continue;
    const std::string command = text_of(entry.path() / "cmdline");
    const std::string file = fs::path(command.c_str()).filename();
    if (file == program) found.push_back(std::stoi(name));
  }
  return found;
}

std::vector<pid_t> honest_program(const std::string& name) {
  std::vector<pid_t> found = processes("negotiation_peer");
  std::erase_if(found, [&](pid_t process) {
    return text_of("/proc/" + std::to_string(process) + "/cmdline").find("\"name\":\"" + name) ==
           std::string::npos;
  });
  return found;
}

}  // namespace sft::hostile
