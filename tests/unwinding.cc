// SPDX-License-Identifier: MIT
//
// unwinding.cc - C++ exceptions, and the end of a thread, pass through libntp.so
//
// Each function that calls one of the user's is run again and again.  The first call of the user's function
// throws in the first run, the second in the second, and so on, until a run ends without.  All that lies
// on the stack at any of these calls needs tables for unwinding; without them an exception ends the
// program, and the destructors of a thread that ends do not run.  Of C libraries only glibc's runs these.
#include "libntp.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <pthread.h>
#include <vector>

namespace
{

const int32_t SIDE = 40;
const int32_t PARTS = 3;

struct thrown {
};

enum class way { exception, thread };

// What throws, or ends the thread, at a given call.
struct fuse {
    way by;
    long left;

    void burn()
    {
        if (left-- > 0)
            return;
        if (by == way::thread)
            pthread_exit(nullptr);
        throw thrown();
    }
};

int32_t progress(void *user, double)
{
    static_cast<fuse *>(user)->burn();
    return 0;
}

void parallel_for(void *user, int32_t count, void (*task)(void *, int32_t), void *work)
{
    for (int32_t i = 0; i < count; i++) {
        static_cast<fuse *>(user)->burn();
        task(work, i);
    }
}

void check(bool good, const char *what)
{
    if (good)
        return;
    std::printf("%s\n", what);
    std::exit(1);
}

// Memory aligned to 64 bytes.
class scratch
{
  public:
    explicit scratch(size_t size) : size(size), bytes(size + 64)
    {
        check(size > 0, "no size of scratch memory");
        start = bytes.data() + (64 - reinterpret_cast<uintptr_t>(bytes.data()) % 64) % 64;
    }
    void *get() const
    {
        return start;
    }
    const size_t size;

  private:
    std::vector<unsigned char> bytes;
    unsigned char *start;
};

// A texture of waves with some noise, its heights, a mask with an island, and room for results.
struct pictures {
    std::vector<unsigned char> levels, holes;
    std::vector<float> heights, other;
    ntp_image normals, mask, surface, result;

    pictures()
        : levels(SIDE * SIDE * 3), holes(SIDE * SIDE), heights(SIDE * SIDE), other(SIDE * SIDE)
    {
        for (int32_t i = 0; i < SIDE * SIDE; i++) {
            const int32_t x = i % SIDE, y = i / SIDE, noise = i * 7919 % 13;
            levels[3 * i] = static_cast<unsigned char>(128 + x * 5 % 70 - 35 + noise);
            levels[3 * i + 1] = static_cast<unsigned char>(128 + y * 3 % 50 - 25 - noise);
            levels[3 * i + 2] = 240;
            holes[i] = x != 20 && y % 17 != 9;
            heights[i] = static_cast<float>(x * y % 23 + noise);
        }
        normals = ntp_image_packed(levels.data(), SIDE, SIDE, 3, NTP_TYPE_U8);
        mask = plane(holes.data(), NTP_TYPE_U8);
        surface = plane(heights.data(), NTP_TYPE_F32);
        result = plane(other.data(), NTP_TYPE_F32);
    }

    static ntp_image plane(void *data, ntp_type type)
    {
        ntp_image image = ntp_image_packed(data, SIDE, SIDE, 1, type);
        image.encoding = NTP_ENCODING_HEIGHT;
        return image;
    }
};

using call = std::function<ntp_status(const ntp_hooks *, fuse *)>;

// A run in a thread of its own, which ends it or not.
struct thread_run {
    const call &run;
    fuse f;
    bool ended, unwound;
};

// Its destructor runs when the frames above the library are unwound.
struct witness {
    thread_run *run;
    ~witness()
    {
        run->unwound = true;
    }
};

void *in_thread(void *argument)
{
    thread_run *t = static_cast<thread_run *>(argument);
    const witness w = { t };
    const ntp_hooks hooks = { &t->f, progress, parallel_for, PARTS };
    t->run(&hooks, &t->f);
    t->ended = true;
    return nullptr;
}

bool ends_by_exception(const call &run, long at)
{
    fuse f = { way::exception, at };
    const ntp_hooks hooks = { &f, progress, parallel_for, PARTS };
    try {
        const ntp_status status = run(&hooks, &f);
        check(status == NTP_OK || status == NTP_ERR_NOT_CONVERGED, ntp_status_string(status));
        return false;
    } catch (const thrown &) {
        return true;
    }
}

bool ends_thread(const call &run, long at)
{
    thread_run t = { run, { way::thread, at }, false, false };
    pthread_t thread;
    check(pthread_create(&thread, nullptr, in_thread, &t) == 0, "no thread");
    check(pthread_join(thread, nullptr) == 0, "a thread that cannot be joined");
    check(t.unwound, "the end of a thread did not pass");
    return !t.ended;
}

void try_all(const char *name, const call &run)
{
    long at = 0;
    while (ends_by_exception(run, at))
        at++;
    std::printf("%s: %ld calls\n", name, at);
    check(at > 0, "no function of the user's was called");
#ifdef __GLIBC__
    long threads = 0;
    while (ends_thread(run, threads))
        threads++;
    check(threads == at, "a function of the user's was not called as often in a thread");
#endif
}

ntp_height_options options(ntp_height_method method, ntp_kernel kernel, ntp_border border)
{
    ntp_height_options how = {};
    how.method = method;
    how.kernel = kernel;
    how.border_x = how.border_y = border;
    return how;
}

void try_heights(pictures &p, const char *name, const ntp_height_options &how)
{
    const scratch room(ntp_height_scratch_size(&how, SIDE, SIDE, PARTS));
    const ntp_const_image src = ntp_image_as_const(&p.normals);
    try_all(name, [&](const ntp_hooks *hooks, fuse *) {
        return ntp_height_from_normals(&p.result, &src, &how, room.get(), room.size, hooks,
                                       nullptr);
    });
}

// The picture of which rows are read and written.
struct rows_of {
    pictures *p;
    fuse *f;
};

int32_t read_normals(void *user, void *rows, int32_t y, int32_t count)
{
    const rows_of *r = static_cast<rows_of *>(user);
    const unsigned char *from = &r->p->levels[static_cast<size_t>(y) * SIDE * 3];
    r->f->burn();
    std::copy(from, from + count * SIDE * 3, static_cast<unsigned char *>(rows));
    return 0;
}

int32_t read_heights(void *user, float *rows, int32_t y, int32_t count)
{
    const rows_of *r = static_cast<rows_of *>(user);
    const float *from = &r->p->other[static_cast<size_t>(y) * SIDE];
    r->f->burn();
    std::copy(from, from + count * SIDE, rows);
    return 0;
}

int32_t write_heights(void *user, const float *rows, int32_t y, int32_t count)
{
    const rows_of *r = static_cast<rows_of *>(user);
    r->f->burn();
    std::copy(rows, rows + count * SIDE, &r->p->other[static_cast<size_t>(y) * SIDE]);
    return 0;
}

void try_rows(pictures &p)
{
    const ntp_height_options how = options(NTP_HEIGHT_AUTO, NTP_KERNEL_CENTRAL, NTP_BORDER_CLAMP);
    const ntp_const_image form = ntp_image_as_const(&p.normals);
    const scratch room(ntp_height_rows_scratch_size(&form, &how, PARTS));
    try_all("rows", [&](const ntp_hooks *hooks, fuse *f) {
        rows_of user = { &p, f };
        const ntp_height_rows rows = { &user, read_normals, read_heights, write_heights };
        return ntp_height_from_rows(&form, &rows, &how, room.get(), room.size, hooks, nullptr);
    });
}

void try_all_heights(pictures &p)
{
    const ntp_const_image mask = ntp_image_as_const(&p.mask);
    ntp_height_options how = options(NTP_HEIGHT_AUTO, NTP_KERNEL_CENTRAL, NTP_BORDER_WRAP);
    try_heights(p, "central, wrap", how);
    how.residual_scope = NTP_RESIDUAL_ALL;
    how.refine = 2;
    try_heights(p, "refined", how);
    try_heights(p, "central, extrapolate",
                options(NTP_HEIGHT_AUTO, NTP_KERNEL_CENTRAL, NTP_BORDER_EXTRAPOLATE));
    try_heights(p, "sobel3, clamp", options(NTP_HEIGHT_AUTO, NTP_KERNEL_SOBEL3, NTP_BORDER_CLAMP));
    how = options(NTP_HEIGHT_WEIGHTED, NTP_KERNEL_CENTRAL, NTP_BORDER_CLAMP);
    how.mask = &mask;
    how.max_iterations = 3;
    try_heights(p, "weighted", how);
    how.max_iterations = 0;
    how.tolerance = 0.1;
    how.refine = 1;
    try_heights(p, "weighted, refined", how);
    how = options(NTP_HEIGHT_TELESCOPING, NTP_KERNEL_CENTRAL, NTP_BORDER_CLAMP);
    how.residual_scope = NTP_RESIDUAL_INSIDE;
    try_heights(p, "telescoping", how);
}

void try_others(pictures &p)
{
    const ntp_const_image surface = ntp_image_as_const(&p.surface);
    const ntp_const_image src = ntp_image_as_const(&p.normals);
    const scratch shade(ntp_occlusion_scratch_size(nullptr, SIDE, SIDE, PARTS));
    try_all("occlusion", [&](const ntp_hooks *hooks, fuse *) {
        return ntp_occlusion(&p.result, &surface, nullptr, shade.get(), shade.size, hooks);
    });
    const scratch depth(ntp_depth_scratch_size(SIDE, SIDE));
    try_all("depth", [&](const ntp_hooks *hooks, fuse *) {
        return ntp_depth_from_normals(&p.result, nullptr, &src, nullptr, depth.get(), depth.size,
                                      hooks, nullptr);
    });
    const ntp_height_options how = options(NTP_HEIGHT_AUTO, NTP_KERNEL_CENTRAL, NTP_BORDER_CLAMP);
    const scratch borders(ntp_find_borders_scratch_size(&how, SIDE, SIDE, PARTS));
    try_all("borders", [&](const ntp_hooks *hooks, fuse *) {
        const int32_t open[2] = { 1, 1 }, wraps[2] = { 1, 0 };
        ntp_border_fit fit[2];
        return ntp_find_borders(fit, &src, &how, open, wraps, borders.get(), borders.size, hooks);
    });
}

} // namespace

int main()
{
    pictures p;
    try_all_heights(p);
    try_rows(p);
    try_others(p);
    return 0;
}
