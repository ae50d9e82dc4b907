#include "frame_claim.h"

#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fumarole/errors.h>

namespace fumarole::command {

std::optional<FrameClaim> FrameClaim::take(const std::filesystem::path& picture)
{
    const std::filesystem::path file = picture.string() + ".lock";
    for (;;) {
        const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (descriptor < 0)
            throw Error(fmt::format("{}: can't be made: {}", file.string(),
                                    std::generic_category().message(errno)));
        FrameClaim claim(file, descriptor);
        if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
            const int error = errno;
            ::close(std::exchange(claim.descriptor_, -1));  // the file is another's
            if (error == EINTR)
                continue;
            if (error == EWOULDBLOCK)
                return std::nullopt;
            throw Error(fmt::format("{}: can't be locked: {}; choose a folder whose file system "
                                    "has locks",
                                    file.string(), std::generic_category().message(error)));
        }
        // Its holder may have removed it between our open and our lock: then this is none.
        struct stat ours {
        }, there{};
        if (::fstat(descriptor, &ours) == 0 && ::stat(file.c_str(), &there) == 0 &&
            ours.st_ino == there.st_ino && ours.st_dev == there.st_dev)
            return claim;
        ::close(std::exchange(claim.descriptor_, -1));
    }
}

FrameClaim::FrameClaim(std::filesystem::path file, int descriptor)
    : file_{std::move(file)}, descriptor_{descriptor}
{
}

FrameClaim::FrameClaim(FrameClaim&& other) noexcept
    : file_{std::move(other.file_)}, descriptor_{std::exchange(other.descriptor_, -1)}
{
}

FrameClaim::~FrameClaim()
{
    if (descriptor_ < 0)
        return;
    ::unlink(file_.c_str());  // while it is held
    ::close(descriptor_);
}

}  // namespace fumarole::command
