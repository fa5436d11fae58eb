// Decides whose sftd a program uses. A daemon, like the owner of its memory, can read all samples in the
// memory and can end every program that maps it. So a program accepts the daemon of root, of its own
// account, of an account that its options name, and of the account to which the administrator has given the
// directory /run/sft (RuntimeDirectory= of a systemd unit does that). A daemon of any other account serves
// only the programs of that account.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "core/platform/trusted_file.h"
#include "sft/result.h"

namespace sft::shm {

inline constexpr const char* run_directory = "/run/sft";

/// Converts names or numbers of accounts to ids. The error Errc::invalid_argument names an account that
/// does not exist.
Result<std::vector<uid_t>> user_ids(const std::vector<std::string>& users);

/// Returns the accounts whose daemons are accepted: root, the account of this process, the accounts in
/// `named`, and the owner of /run/sft.
core::TrustedAccounts accepted_daemons(std::vector<uid_t> named);

/// Returns a text that says why the daemon of this account is not used, and what to do.
std::string why_not_accepted(uid_t user);

}  // namespace sft::shm
