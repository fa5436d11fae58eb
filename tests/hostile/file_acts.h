// Acts with files: obstacles at names that sftd and programs use, locks, and full memory.
#pragma once

#include "tests/hostile/act.h"

namespace sft::hostile {

Act fifos(Target& target);
Act directories(Target& target);
Act dangling_links(Target& target);
Act links_to_files_of_the_honest(Target& target);
Act closed_files(Target& target);
Act open_files(Target& target);
Act hard_links(Target& target);
Act sockets(Target& target);
Act snatched_names(Target& target);
Act read_locks(Target& target);
Act waiting_read_locks(Target& target);
Act full_shared_memory(Target& target);
Act full_tmp(Target& target);
Act no_file_numbers(Target& target);

}  // namespace sft::hostile
