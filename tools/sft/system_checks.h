// The checks of `sft doctor` that need no node. Each check reads a state of the system, without waiting.
#pragma once

#include "tools/sft/finding.h"

namespace sft::tool {

Finding check_kernel();
Finding check_loopback();
Finding check_memlock();
Finding check_receive_buffers();
Finding check_open_files();
Finding check_proc();
Finding check_tmp();
Finding check_dev_shm();
Finding check_users();
Finding check_clock();

}  // namespace sft::tool
