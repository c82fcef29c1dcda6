// A request to end long work early. The work polls it after every small part. Plain functions, without Python.
#pragma once

namespace urdf_ik {

struct Stop {
    bool (*asks)(void* self);
    void* self;
    bool asked() const { return asks(self); }
};

}  // namespace urdf_ik
