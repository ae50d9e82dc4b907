#include "window/reference_worker.h"

#include <algorithm>
#include <oneapi/tbb/task_arena.h>
#include <thread>

#include "study/reference.h"
#include "window/glfw_window.h"

namespace fumarole::window {

void ReferenceWorker::start(const Scene& scene, double tolerance, int bounces)
{
    mail_ = std::make_shared<Mail>();
    Picture& picture = mail_->picture;
    picture.width = static_cast<int>(scene.resolution.x);
    picture.height = static_cast<int>(scene.resolution.y);
    const std::size_t pixels = std::size_t{scene.resolution.x} * scene.resolution.y;
    picture.composite.assign(pixels * 3, 0.0f);
    picture.done.assign(pixels, 0);
    picture.version = versions_ += std::uint64_t{1} << 32u;
    task_.run([scene, tolerance, bounces, mail = mail_](const Background::Stop& stop) {
        study::ReferenceOptions options;
        options.tolerance = tolerance;
        options.bounces = bounces;
        options.surface_bounces = study::measured_surface_bounces(scene);
        options.cancel = &stop;
        options.on_tile = [&](const study::ReferenceRegion& tile,
                              const study::ReferenceStill& still) {
            const std::lock_guard lock(mail->lock);
            Picture& to = mail->picture;
            for (int y = tile.y; y < tile.y + tile.height; ++y) {
                const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(to.width) +
                                 static_cast<std::size_t>(tile.x);
                const auto length = static_cast<std::size_t>(tile.width);
                std::copy_n(still.composite.begin() + static_cast<std::ptrdiff_t>(row * 3),
                            length * 3,
                            to.composite.begin() + static_cast<std::ptrdiff_t>(row * 3));
                std::fill_n(to.done.begin() + static_cast<std::ptrdiff_t>(row), length,
                            std::uint8_t{1});
            }
            to.share +=
                static_cast<double>(tile.width) * tile.height / static_cast<double>(to.done.size());
            ++to.version;
        };
        try {
            // A core is left for the window.
            const int cores = static_cast<int>(std::thread::hardware_concurrency());
            oneapi::tbb::task_arena arena(std::max(1, cores - 1));
            arena.execute([&] { study::render_reference(scene, options); });
            const std::lock_guard lock(mail->lock);
            mail->picture.whole = true;
            ++mail->picture.version;
        } catch (const study::ReferenceCancelled&) {
        } catch (const std::exception& error) {
            const std::lock_guard lock(mail->lock);
            mail->picture.error = error.what();
            ++mail->picture.version;
        }
    });
}

void ReferenceWorker::stop()
{
    task_.stop();
}

void ReferenceWorker::update(Picture& picture) const
{
    const std::lock_guard lock(mail_->lock);
    if (picture.version != mail_->picture.version)
        picture = mail_->picture;
}

}  // namespace fumarole::window
