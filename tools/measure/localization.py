"""Held-out errors, by the rule of `raygrid evaluate`: the camera and its board are fixed, and each
image's pose is the least squares one of reprojection errors under Huber's loss of 1 px, without
corners that are more than 3 px and six times the median off. All corners count in the errors."""
import numpy as np

HUBER_PX = 1
ALWAYS_PX, TIMES_MEDIAN = 3, 6
ROUNDS = 5
FAR_OFF_PX = 1e4  # what a corner that the camera does not see counts


def rotation_matrix(vector):
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def residuals(project, pose, points, pixels):
    """Projected less observed, one row a corner."""
    rotation, translation = pose
    errors = project(points @ rotation.T + translation) - pixels
    return np.where(np.isfinite(errors), errors, FAR_OFF_PX)


def moved(pose, step):
    turn = rotation_matrix(step[:3])
    return turn @ pose[0], turn @ pose[1] + step[3:]


def huber_cost(errors):
    norms = np.linalg.norm(errors, axis=1)
    return np.sum(np.where(norms <= HUBER_PX, norms ** 2, 2 * HUBER_PX * norms - HUBER_PX ** 2))


def jacobian(project, pose, points, pixels, scale_m):
    columns = []
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-6 if k < 3 else 1e-6 * scale_m
        difference = (residuals(project, moved(pose, step), points, pixels) -
                      residuals(project, moved(pose, -step), points, pixels))
        columns.append(difference.ravel() / (2 * step[k]))
    return np.stack(columns, axis=1)


def refine(project, pose, points, pixels):
    """Levenberg-Marquardt with Huber's weights."""
    errors = residuals(project, pose, points, pixels)
    cost, damping = huber_cost(errors), 1e-3
    for _ in range(200):
        norms = np.linalg.norm(errors, axis=1)
        weights = np.repeat(np.minimum(1, HUBER_PX / np.maximum(norms, 1e-12)), 2)
        j = jacobian(project, pose, points, pixels, np.linalg.norm(pose[1]))
        normal, gradient = j.T @ (weights[:, None] * j), j.T @ (weights * errors.ravel())
        accepted = False
        while not accepted and damping < 1e12:
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), -gradient)
            candidate = moved(pose, step)
            new_errors = residuals(project, candidate, points, pixels)
            new_cost = huber_cost(new_errors)
            accepted = new_cost < cost
            damping = max(damping / 10, 1e-12) if accepted else damping * 10
        if not accepted:
            break
        converged = cost - new_cost < 1e-12 * cost
        pose, errors, cost = candidate, new_errors, new_cost
        if converged:
            break
    return pose


def localize(project, start, points, pixels):
    kept = np.ones(len(points), bool)
    pose = start
    for _ in range(ROUNDS):
        pose = refine(project, pose, points[kept], pixels[kept])
        norms = np.linalg.norm(residuals(project, pose, points, pixels), axis=1)
        limit = max(ALWAYS_PX, TIMES_MEDIAN * np.median(norms[kept]))
        consistent = kept & (norms <= limit)
        if consistent.sum() == kept.sum() or consistent.sum() < 4:
            break
        kept = consistent
    return pose


def errors_px(project, board, views, starts):
    """Norms of all corners' residuals. Poses start from the same ones for all peers."""
    norms = []
    for view in views:
        points = board[view.places]
        pose = localize(project, starts[view.image], points, view.pixels)
        norms.extend(np.linalg.norm(residuals(project, pose, points, view.pixels), axis=1))
    return np.array(norms)


def figures(norms):
    return {"median": float(np.median(norms)), "rms": float(np.sqrt(np.mean(norms ** 2))),
            "p95": float(np.percentile(norms, 95)), "count": len(norms)}
