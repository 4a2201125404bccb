// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "benchmarks/ray_recorder.h"

#include <utility>

namespace stillray::render {
namespace {

class RecordingAccel final : public Accel {
 public:
  RecordingAccel(std::unique_ptr<Accel> inner, RayLogs* logs)
      : inner_(std::move(inner)), logs_(*logs) {}

  Status Update(const std::vector<AccelPlace>& places) override { return inner_->Update(places); }
  void IntersectCoherent(const RayBatch& rays, HitBatch* hits) const override {
    Keep(rays, RayPhase::kPrimary);
    inner_->IntersectCoherent(rays, hits);
  }
  void IntersectIncoherent(const RayBatch& rays, HitBatch* hits) const override {
    Keep(rays, RayPhase::kBounce);
    inner_->IntersectIncoherent(rays, hits);
  }
  void Occluded(const RayBatch& rays, vec3* transmittance) const override {
    Keep(rays, RayPhase::kShadow);
    inner_->Occluded(rays, transmittance);
  }
  size_t memory_bytes() const override { return inner_->memory_bytes(); }

 private:
  void Keep(const RayBatch& rays, RayPhase phase) const {
    RayLog& log = logs_[static_cast<size_t>(phase)];
    log.batches.push_back({log.count(), rays.count});
    const float* parts[] = {rays.origin_x,    rays.origin_y,    rays.origin_z, rays.direction_x,
                            rays.direction_y, rays.direction_z, rays.end};
    for (size_t k = 0; k < log.values.size(); ++k) {
      log.values[k].insert(log.values[k].end(), parts[k], parts[k] + rays.count);
    }
  }

  std::unique_ptr<Accel> inner_;
  RayLogs& logs_;
};

}  // namespace

std::unique_ptr<Accel> MakeRecordingAccel(std::unique_ptr<Accel> inner, RayLogs* logs) {
  return std::make_unique<RecordingAccel>(std::move(inner), logs);
}

}  // namespace stillray::render
