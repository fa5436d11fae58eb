#include "shm_transport/daemon/accepted_daemons.h"

#include <pwd.h>
#include <sys/stat.h>

#include <array>
#include <charconv>
#include <optional>

namespace sft::shm {

namespace {

std::optional<uid_t> user_id(const std::string& user) {
  uid_t id = 0;
  const auto [end, error] = std::from_chars(user.data(), user.data() + user.size(), id);
  if (error == std::errc{} && end == user.data() + user.size()) return id;
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> text;
  if (getpwnam_r(user.c_str(), &entry, text.data(), text.size(), &found) != 0 || found == nullptr)
    return std::nullopt;
  return found->pw_uid;
}

/// Returns the owner of /run/sft if only root can write to /run. Returns nothing in any other case, because
/// any account could have made the directory.
std::optional<uid_t> owner_of_run_directory() {
  struct stat parent {};
  struct stat directory {};
  if (lstat("/run", &parent) != 0 || lstat(run_directory, &directory) != 0) return std::nullopt;
  const bool only_root_made_it = parent.st_uid == 0 && (parent.st_mode & (S_IWGRP | S_IWOTH)) == 0;
  if (!only_root_made_it || !S_ISDIR(directory.st_mode)) return std::nullopt;
  return directory.st_uid;
}

}  // namespace

Result<std::vector<uid_t>> user_ids(const std::vector<std::string>& users) {
  std::vector<uid_t> ids;
  for (const std::string& user : users) {
    const std::optional<uid_t> id = user_id(user);
    if (!id)
      return fail(Errc::invalid_argument, "shm.daemon_users: there is no user '" + user +
                                              "'; give the name of a user of this host, or "
                                              "the user's number");
    ids.push_back(*id);
  }
  return ids;
}

core::TrustedAccounts accepted_daemons(std::vector<uid_t> named) {
  core::TrustedAccounts accounts{.users = std::move(named)};
  if (const auto owner = owner_of_run_directory()) accounts.users.push_back(*owner);
  return accounts;
}

std::string why_not_accepted(uid_t user) {
  const std::string name = core::account_name(user);
  return "the sftd of " + name +
         " is not accepted, because it would see all samples; end it and start sftd as root or as this user, "
         "or "
         "name " +
         name.substr(name.find(' ') + 1) + " in shm.daemon_users";
}

}  // namespace sft::shm
