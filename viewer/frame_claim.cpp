#include "frame_claim.h"

#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>

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

bool is_whole(const std::filesystem::path& picture, glm::ivec2 size)
{
    std::error_code unknown;
    if (!std::filesystem::is_regular_file(picture, unknown))
        return false;
    const auto input = OIIO::ImageInput::open(picture.string());
    if (!input) {
        OIIO::geterror();  // or it is printed at the end
        return false;
    }
    const OIIO::ImageSpec& spec = input->spec();
    bool whole = spec.width == size.x && spec.height == size.y;
    if (whole && spec.deep) {
        OIIO::DeepData data;
        whole = input->read_native_deep_image(0, 0, data);
    } else if (whole) {
        std::vector<float> pixels(static_cast<std::size_t>(size.x) *
                                  static_cast<std::size_t>(size.y) *
                                  static_cast<std::size_t>(spec.nchannels));
        whole = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data());
    }
    if (!whole)
        static_cast<void>(input->geterror());
    return whole;
}

}  // namespace fumarole::command
