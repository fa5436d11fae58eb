// expect: no matching (member )?function for call to .*set
#include "tests/compile_fail/cloud.h"

void misuse(sft::Loan<PointCloud2>& loan) { loan.set(Image::Field::width, 1); }
