"""Rows of accuracy.csv, localization.csv and sets.csv."""

FIGURES = ("median", "rms", "p95")


def number(value):
    return f"{value:.3f}"


def is_same(first, second):
    keys = ("model", "target", "peer", "parameters")
    if "failed" in first or "failed" in second or any(first[k] != second[k] for k in keys):
        return False
    pairs = [(first["train"]["median"], second["train"]["median"])]
    pairs += [(first["test"][k], second["test"][k]) for k in FIGURES]
    return all(abs(a - b) < 1e-3 for a, b in pairs)


def merged(rows):
    """Rows of two versions as one where they agree."""
    left = []
    for row in rows:
        twin = next((r for r in left if is_same(r, row)), None)
        if twin:
            twin["version"] += ", " + row["version"]
        else:
            left.append(dict(row))
    return left


def head_of(name, row):
    return {"set": name, "program": row["peer"], "version": row["version"], "model": row["model"],
            "target": row["target"]}


def order_of(row):
    return ("failed" in row, row["test"]["median"] if "test" in row else 0)


def accuracy_rows(results):
    """By set in the order of the held-out median; failures at the end."""
    for result in results:
        for row in sorted(merged(result["rows"]), key=order_of):
            out = head_of(result["job"]["name"], row)
            if "failed" in row:
                yield {**out, "failure": row["failed"]}
                continue
            test = {f"{name}_px": number(row["test"][name]) for name in FIGURES}
            yield {**out, "parameters": row["parameters"], "train_median_px": number(row["train"]["median"]), **test,
                   "corners": row["test"]["count"], "seconds": f"{row['seconds']:.1f}"}


def localization_rows(results):
    """One camera by the code that localizes raygrid's cameras, and by that of the peers."""
    for result in results:
        by_raygrid = next(r for r in result["rows"]
                          if (r["peer"], r["model"], r["target"]) == ("raygrid", "opencv", "nominal"))["test"]
        by_peers = result["by_peers_rule"]
        yield {"set": result["job"]["name"], "raygrid_median_px": f"{by_raygrid['median']:.4f}",
               "raygrid_corners": by_raygrid["count"], "peers_median_px": f"{by_peers['median']:.4f}",
               "peers_corners": by_peers["count"]}


def set_rows(results):
    for result in results:
        name = result["job"]["name"]
        yield {"set": name, "description": result["job"]["title"].removeprefix(name + ": ")}
