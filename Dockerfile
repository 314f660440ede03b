# docker build -t dockloop . && docker run --rm -v "$PWD/results:/data/results" dockloop run low_frequency
FROM python:3.12-slim AS build
WORKDIR /source
COPY . .
RUN pip install --no-cache-dir build && python -m build --wheel --outdir /wheels

FROM python:3.12-slim
COPY --from=build /wheels /wheels
# g++ is not needed: the FMUs are in the wheel; casadi and ziglang of [native] build new ones
RUN wheel="$(echo /wheels/*.whl)" && pip install --no-cache-dir "${wheel}[native]" && rm -r /wheels \
    && useradd --create-home user && mkdir -p /data/results && chown -R user /data
USER user
WORKDIR /data
# the stepping loop is compiled once, into the image
RUN dockloop run low_frequency --stop-time 0.1 && rm -r results/*
ENTRYPOINT ["dockloop"]
CMD ["--help"]
