// Whose sftd a program uses. A daemon and whoever owns its memory sees all samples that are in it, and can
// end every program that maps it. So a program accepts the daemon of root, of its own account, of an account
// that its options name, and of the account that the administrator has given the directory /run/sft to (a
// service manager's RuntimeDirectory= does that). Whoever else starts one first has it for itself.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "core/platform/trusted_file.h"
#include "sft/result.h"

namespace sft::shm {

inline constexpr const char* run_directory = "/run/sft";

/// Ids of accounts given by name or as numbers. Errc::invalid_argument names the one that does not exist.
Result<std::vector<uid_t>> user_ids(const std::vector<std::string>& users);

/// Root's, this process's own, these, and the owner of /run/sft.
core::TrustedAccounts accepted_daemons(std::vector<uid_t> named);

/// Why the daemon of that account is not used, and what to do.
std::string why_not_accepted(uid_t user);

}  // namespace sft::shm
