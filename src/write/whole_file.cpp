#include "write/whole_file.h"

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <string>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fumarole/errors.h>

namespace fumarole::write {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& file)
{
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// What a failed system call on `file` means for the person who asked for it, with what to do.
std::string reason_for(int error, const fs::path& file, std::size_t bytes)
{
    const std::string folder = folder_of(file).string();
    switch (error) {
    case ENOENT: {
        std::error_code unknown;  // of a folder that is there it means that none can be made there
        if (fs::is_directory(folder_of(file), unknown)) {
            return fmt::format("folder '{}' takes no new files; choose another", folder);
        }
        return fmt::format("no such folder '{}'; create it first", folder);
    }
    case ENOTDIR:
        return fmt::format("'{}' is not a folder; choose another", folder);
    case EACCES:
    case EPERM:
        return fmt::format("no right to write in folder '{}'; choose another or change its rights",
                           folder);
    case EROFS:
        return fmt::format("folder '{}' is read-only; choose another", folder);
    case ENOSPC:
    case EDQUOT:
        return fmt::format("disk full; free {:.1f} MB in folder '{}' or choose another",
                           static_cast<double>(bytes) * 1e-6, folder);
    case EFBIG:
        return fmt::format("{} bytes are over the limit for a file; raise it (ulimit -f)", bytes);
    case ENAMETOOLONG:
        return "the name is too long; choose a shorter one";
    default:
        return fmt::format("{}; choose another folder than '{}'",
                           std::generic_category().message(error), folder);
    }
}

// An unfinished file: gone again unless it was renamed to its name.
class TemporaryFile {
public:
    // Beside the destination, since rename is atomic only within one file system. Not named after
    // it: a name of legal length must not become too long.
    explicit TemporaryFile(const fs::path& destination)
    {
        static std::atomic<unsigned> count = 0;
        do {
            path_ =
                folder_of(destination) / fmt::format(".fumarole-{}-{}.tmp", ::getpid(), count++);
            // 0666 less umask, as any program's file; mkstemp's 0600 would survive the rename.
            descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        } while (descriptor_ < 0 && errno == EEXIST);
        error_ = descriptor_ < 0 ? errno : 0;
        created_ = descriptor_ >= 0;
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile()
    {
        if (descriptor_ >= 0) {
            ::close(descriptor_);
        }
        if (created_) {
            ::unlink(path_.c_str());
        }
    }

    // Each returns 0, or the errno of the first step that failed; later steps then do nothing.
    int write(std::span<const unsigned char> bytes)
    {
        while (error_ == 0 && !bytes.empty()) {
            const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
            if (written >= 0) {
                bytes = bytes.subspan(static_cast<std::size_t>(written));
            } else if (errno != EINTR) {
                error_ = errno;
            }
        }
        return error_;
    }

    int become(const fs::path& destination)
    {
        // Network file systems report a full disk only here.
        if (error_ == 0 && ::close(std::exchange(descriptor_, -1)) != 0) {
            error_ = errno;
        }
        if (error_ == 0 && ::rename(path_.c_str(), destination.c_str()) != 0) {
            error_ = errno;
        }
        created_ = created_ && error_ != 0;
        return error_;
    }

private:
    fs::path path_;
    int descriptor_ = -1;
    int error_ = 0;
    bool created_ = false;
};

}  // namespace

void write_whole(const fs::path& file, std::span<const unsigned char> bytes)
{
    if (!file.has_filename()) {
        throw Error(fmt::format("'{}': no file name; add one", file.string()));
    }
    std::error_code ignored;  // what cannot be asked about fails below, with its reason
    const fs::file_status status = fs::status(file, ignored);
    if (fs::is_directory(status)) {
        throw Error(fmt::format("{}: is a folder; name a file", file.string()));
    }
    // A rename would replace /dev/null itself.
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        throw Error(fmt::format("{}: is not a regular file; choose another", file.string()));
    }
    // A rename needs no right on the file that it replaces; who protected it does not expect that.
    if (fs::exists(status) && ::access(file.c_str(), W_OK) != 0) {
        throw Error(fmt::format("{}: is write-protected; choose another or change its rights",
                                file.string()));
    }

    TemporaryFile temporary(file);
    int error = temporary.write(bytes);
    if (error == 0) {
        error = temporary.become(file);
    }
    if (error != 0) {
        throw Error(fmt::format("{}: {}", file.string(), reason_for(error, file, bytes.size())));
    }
}

}  // namespace fumarole::write
