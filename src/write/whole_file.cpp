#include "write/whole_file.h"

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
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

/// What a failed system call on `file` means for the person who asked for it, with what to do.
std::string reason_for(int error, const fs::path& file, std::size_t bytes)
{
    const std::string folder = folder_of(file).string();
    std::error_code unknown;
    switch (error) {
    case ENOENT:
        if (fs::is_directory(folder, unknown))
            return fmt::format("folder '{}' takes no new files; choose another", folder);
        return fmt::format("no such folder '{}'; create it first", folder);
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
    case ENXIO:
        return "nobody reads this pipe; start its reader first";
    default:
        return fmt::format("{}; choose another folder than '{}'",
                           std::generic_category().message(error), folder);
    }
}

[[noreturn]] void fail(const fs::path& file, int error, std::size_t bytes)
{
    throw Error(
        fmt::format("{}: {}", file.string(), reason_for(error != 0 ? error : EIO, file, bytes)));
}

/// @returns 0, or the errno of the first step that failed. A network's file system reports a full
/// disk only as the file is closed.
int write_bytes(const fs::path& path, int flags, std::string_view bytes)
{
    // 0666 less umask, as any program's file; mkstemp's 0600 would survive the rename.
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
    if (descriptor < 0)
        return errno;
    int error = 0;
    while (error == 0 && !bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written >= 0)
            bytes.remove_prefix(static_cast<std::size_t>(written));
        else if (errno != EINTR)
            error = errno;
    }
    if (::close(descriptor) != 0 && error == 0)
        error = errno;
    return error;
}

/// A pipe that nobody reads is an error, not a wait for ever; what is read may take its time.
int write_into(const fs::path& device, std::string_view bytes)
{
    const int reader = ::open(device.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (reader < 0)
        return errno;
    const int error = write_bytes(device, 0, bytes);
    ::close(reader);
    return error;
}

}  // namespace

UnfinishedFile::UnfinishedFile(fs::path file) : file_{std::move(file)}
{
    // Beside the file, since a rename is atomic only within one file system. Not named after it: a
    // name of legal length must not become too long. It ends alike, for programs that go by that.
    static std::atomic<unsigned> counter{0};
    std::error_code unknown;
    do {
        path_ = file_.parent_path() / fmt::format(".fumarole-{}-{}.part{}", ::getpid(), counter++,
                                                  file_.extension().string());
    } while (fs::exists(fs::symlink_status(path_, unknown)));
}

UnfinishedFile::~UnfinishedFile()
{
    std::error_code ignored;
    fs::remove(path_, ignored);
}

void UnfinishedFile::finish()
{
    std::error_code error;
    fs::rename(path_, file_, error);
    if (error)
        fail(file_, error.value(), 0);
}

void write_whole(const fs::path& file, std::string_view bytes)
{
    if (!file.has_filename())
        throw Error(fmt::format("'{}': no file name; add one", file.string()));
    std::error_code unknown;  // what cannot be asked about fails below, with its reason
    const fs::file_status status = fs::status(file, unknown);
    const bool there = fs::exists(status);
    if (fs::is_directory(status))
        throw Error(fmt::format("{}: is a folder; name a file", file.string()));
    if (there && !fs::is_regular_file(status)) {
        if (const int error = write_into(file, bytes))
            fail(file, error, bytes.size());
        return;
    }
    // A rename needs no right on the file that it replaces; who protected it does not expect that.
    if (there && ::access(file.c_str(), W_OK) != 0)
        throw Error(fmt::format("{}: is write-protected; choose another or change its rights",
                                file.string()));
    fs::path target = fs::canonical(file, unknown);
    if (unknown)
        target = file;
    UnfinishedFile unfinished(target);
    if (const int error = write_bytes(unfinished.path(), O_CREAT | O_EXCL, bytes))
        fail(file, error, bytes.size());
    if (there)
        fs::permissions(unfinished.path(), status.permissions(), unknown);  // if we may
    unfinished.finish();
}

void write_whole(const fs::path& file, std::span<const unsigned char> bytes)
{
    write_whole(file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

std::string read_whole(const fs::path& file)
{
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream bytes;
    bytes << stream.rdbuf();
    if (!stream || fs::is_directory(file))
        throw Error(fmt::format("{}: {}", file.string(),
                                std::generic_category().message(errno != 0 ? errno : EISDIR)));
    return bytes.str();
}

}  // namespace fumarole::write
