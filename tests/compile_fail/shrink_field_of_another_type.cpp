// expect: no matching (member )?function for call to .*shrink
#include "tests/compile_fail/cloud.h"

void misuse(sft::Loan<PointCloud2>& loan) { loan.shrink(Image::Field::data, 1); }
